//! A setting in a scene.

use bevy::prelude::*;
use bevy_voxel_gi::{
    Sky, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiState, VoxelGiVolume,
};

use super::{
    noise,
    picture::{difference, picture},
    settings::{SPANS, Setting},
};
use crate::{
    boxes::{BoxScene, TracedScene, agreement, picture_noise, spawn_box_scene},
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat},
    record::{Measurement, ReportAdapter},
    tradeoff::interleaved::Candidate,
};

/// What the rows are compared with, as records name it.
pub(super) const REFERENCE: &str = "path traced";
/// Frames before which every pipeline must have been compiled.
pub(super) const MAX_FRAMES: u32 = 200;
/// Frames before which the light must have settled.
const MAX_SETTLE: u32 = 400;

/// The app of a setting, ready to be timed, and its row with error and memory; the adapter.
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered or the light does not settle.
pub fn candidate(
    truth: &TracedScene,
    setting: &Setting,
) -> Result<(Candidate<HeadlessApp>, ReportAdapter), HeadlessError> {
    let scene = &truth.scene;
    let mut app = app(scene)?;
    let without = picture(&mut app)?;
    let resolution = setting.settings.resolution;
    let world = app.world_mut();
    world.insert_resource(setting.settings.clone());
    let volume = world.spawn(placed(scene, resolution)).id();
    settle(&mut app)?;
    let bounced = difference(&picture(&mut app)?, &without);
    let found = agreement(&bounced, scene.camera.width, &truth.indirect);
    let report = *app.world().resource::<VoxelGiReport>();
    let is_compared = setting.is_compared();
    let mut row = Measurement {
        scene: scene.name.clone(),
        setting: setting.name.clone(),
        reference: REFERENCE.into(),
        bytes: Some(report.memory),
        relative_error: is_compared.then_some(found.relative_error),
        bias: is_compared.then_some(found.bias),
        noise: if is_compared {
            picture_noise(&bounced, scene, resolution)
        } else {
            None
        },
        ..Measurement::default()
    };
    if is_compared && !scene.point_lights.is_empty() {
        row.noise_in_motion = noise::in_motion(&mut app, scene, volume)?;
    }
    never_pause(&mut app)?;
    let adapter = app.adapter().into();
    Ok((Candidate::new(app, row).with_stages(SPANS), adapter))
}

/// The scene without a volume, ready.
fn app(scene: &BoxScene) -> Result<HeadlessApp, HeadlessError> {
    let settings = HeadlessSettings {
        format: TargetFormat::Float32,
        ..HeadlessSettings::with_size(scene.camera.width, scene.camera.height)
    };
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(VoxelGiPlugin).add_systems(Update, stir);
    })?;
    spawn_box_scene(app.world_mut(), scene);
    app.run_until_ready(MAX_FRAMES)?;
    Ok(app)
}

/// A volume of so many voxels along an edge that fits the scene, with its sky.
pub fn placed(scene: &BoxScene, resolution: u32) -> (VoxelGiVolume, Transform) {
    let (center, size) = scene.volume(resolution);
    let volume = VoxelGiVolume {
        size,
        sky: Sky::uniform(LinearRgba::from_vec3(scene.sky_radiance)),
        ..default()
    };
    (volume, Transform::from_translation(center))
}

/// Renders until the light has settled.
pub(super) fn settle(app: &mut HeadlessApp) -> Result<(), HeadlessError> {
    for _ in 0..MAX_SETTLE {
        app.render_frames(1)?;
        if app.world().resource::<VoxelGiReport>().state == VoxelGiState::Settled {
            return Ok(());
        }
    }
    Err(HeadlessError::NotReady {
        frames: MAX_SETTLE,
        waiting: vec!["the light".into()],
    })
}

/// Asks [`stir`] to move a mesh.
#[derive(Resource)]
pub(super) struct IsStirred;

/// Moves a mesh to and fro by a tenth of a millimetre, so that the scene is voxelised in each frame.
pub(super) fn stir(
    is_stirred: Option<Res<IsStirred>>,
    mut meshes: Query<&mut Transform, With<Mesh3d>>,
    mut frame: Local<u32>,
) {
    if is_stirred.is_none() {
        return;
    }
    *frame += 1;
    if let Some(mut transform) = meshes.iter_mut().next() {
        transform.translation.x += if frame.is_multiple_of(2) { 1e-4 } else { -1e-4 };
    }
}

/// Lets all of the volumes be renewed in each frame, as where something moves.
pub(super) fn never_pause(app: &mut HeadlessApp) -> Result<(), HeadlessError> {
    let world = app.world_mut();
    world.insert_resource(IsStirred);
    world.resource_mut::<VoxelGiSettings>().pause_when_settled = false;
    // Times come back a few frames late, and the first frames renew what others do in turn.
    app.render_frames(8)
}

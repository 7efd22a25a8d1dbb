//! A setting in a scene of boxes: its picture, its noise, settled and while a light moves, and its app.

use bevy::prelude::*;
use bevy_frugal_lab::{
    boxes::{BoxScene, TracedScene, agreement, picture_noise, spawn_box_scene},
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat},
};
use bevy_voxel_gi::{
    Sky, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiState, VoxelGiVolume,
};

use crate::voxel_gi::{LightRow, settings::Setting};

/// Frames before which every pipeline must have been compiled.
pub(super) const MAX_FRAMES: u32 = 200;
/// Frames before which the light must have settled.
const MAX_SETTLE: u32 = 400;

/// The app of a setting, ready to be timed, and its row with error and memory.
pub fn candidate(
    truth: &TracedScene,
    setting: &Setting,
) -> Result<(HeadlessApp, LightRow), HeadlessError> {
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
    let mut row = LightRow {
        scene: scene.name.clone(),
        setting: setting.name.clone(),
        bytes: Some(report.memory),
        relative_error: is_compared.then_some(found.relative_error),
        bias: is_compared.then_some(found.bias),
        noise: if is_compared {
            picture_noise(&bounced, scene, resolution)
        } else {
            None
        },
        ..LightRow::default()
    };
    if is_compared && !scene.point_lights.is_empty() {
        row.noise_in_motion = in_motion(&mut app, scene, volume)?;
    }
    never_pause(&mut app)?;
    Ok((app, row))
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
        sky: Some(Sky::uniform(LinearRgba::from_vec3(scene.sky_radiance))),
        ..VoxelGiVolume::fixed(size)
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

/// Frames in which the lights move, at 60 a second.
const MOTION_FRAMES: u16 = 60;
/// Speed of the lights in metres a second.
const SPEED: f32 = 1.0;

/// The noise of the light of a settled volume after the point lights have moved for a second, along X and
/// through their places in the middle of it. They are back at the end.
pub fn in_motion(
    app: &mut HeadlessApp,
    scene: &BoxScene,
    volume: Entity,
) -> Result<Option<f64>, HeadlessError> {
    let step = SPEED / 60.0;
    let half = 0.5 * step * f32::from(MOTION_FRAMES);
    move_lights(app.world_mut(), -half);
    for _ in 0..MOTION_FRAMES {
        move_lights(app.world_mut(), step);
        app.render_frames(1)?;
    }
    let with = picture(app)?;
    let world = app.world_mut();
    let parts = world.entity_mut(volume).take::<VoxelGiVolume>();
    // The frame in which the volume ends may still show it.
    app.render_frames(2)?;
    let without = picture(app)?;
    let world = app.world_mut();
    let resolution = world.resource::<VoxelGiSettings>().resolution;
    world.entity_mut(volume).insert(parts.unwrap_or_default());
    move_lights(world, -half);
    Ok(picture_noise(
        &difference(&with, &without),
        scene,
        resolution,
    ))
}

fn move_lights(world: &mut World, by: f32) {
    let mut lights = world.query_filtered::<&mut Transform, With<PointLight>>();
    for mut pose in lights.iter_mut(world) {
        pose.translation.x += by;
    }
}

/// The picture of the last frame.
pub(super) fn picture(app: &mut HeadlessApp) -> Result<Vec<Vec3>, HeadlessError> {
    let image = app.capture_f32()?;
    let rgb = |p: &[f32; 4]| Vec3::new(p[0], p[1], p[2]);
    Ok(image.pixels.iter().map(rgb).collect())
}

/// One picture less another.
pub(super) fn difference(with: &[Vec3], without: &[Vec3]) -> Vec<Vec3> {
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

/// Means of 2 x 2 pixels of a picture of this width.
pub(super) fn halved(picture: &[Vec3], width: u32) -> Vec<Vec3> {
    let width = width as usize;
    let rows = picture.chunks_exact(2 * width);
    rows.flat_map(|rows| {
        let pixel = move |x: usize| rows[x] + rows[x + 1] + rows[x + width] + rows[x + width + 1];
        (0..width / 2).map(move |x| 0.25 * pixel(2 * x))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_of_a_halved_picture_are_means() {
        let picture: Vec<_> = (0..16).map(|i| Vec3::splat(i as f32)).collect();
        let halved = halved(&picture, 4);
        assert_eq!(halved, [2.5, 4.5, 10.5, 12.5].map(Vec3::splat));
    }
}

//! The same setting with more and more triangles: spheres in a volume, and a light.

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, LabTarget},
    scenes::UNGRADED,
};
use bevy_voxel_gi::{VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiVolume};
use indicatif::ProgressBar;

use crate::{
    benchmark::benchmark_apps,
    plan::GiPlan,
    record::TimeRow,
    voxel_gi::{render, settings::SPANS},
};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;
/// Spheres along each edge of the volume.
const SPHERES: u32 = 3;
/// Edge of the volume in metres.
const SIZE: f32 = 6.0;
/// Edge of the picture in pixels: small, as the volume is what is measured.
const PICTURE: u32 = 64;

/// The rows, one a number of triangles.
pub fn rows(plan: &GiPlan, progress: &ProgressBar) -> Result<Vec<TimeRow>, HeadlessError> {
    let mut candidates = Vec::new();
    let resolution = plan.resolutions[0];
    for &triangles in &plan.triangles {
        progress.set_message(format!("{triangles} triangles"));
        let settings = VoxelGiSettings {
            resolution,
            ..default()
        };
        candidates.push(app(triangles, Some(settings), [PICTURE; 2])?);
        progress.inc(1);
    }
    benchmark_apps(
        candidates,
        plan.rounds,
        plan.frames,
        Some(SPANS),
        TimeRow::with_times,
    )
}

/// An app with spheres of so many triangles, with a volume around them where there are settings, that is renewed in
/// each frame; and its row, without times.
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered.
pub fn app(
    triangles: u32,
    light: Option<VoxelGiSettings>,
    picture: [u32; 2],
) -> Result<(HeadlessApp, TimeRow), HeadlessError> {
    let settings = HeadlessSettings::with_size(picture[0], picture[1]);
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(VoxelGiPlugin)
            .add_systems(Update, render::stir);
    })?;
    let world = app.world_mut();
    spawn_spheres(world, triangles);
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((
        Camera3d::default(),
        target,
        Msaa::Off,
        UNGRADED,
        Transform::from_xyz(0.0, 0.0, SIZE).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let resolution = light.as_ref().map_or(0, |light| light.resolution);
    let has_volume = light.is_some();
    if let Some(light) = light {
        world.insert_resource(light);
        world.spawn(VoxelGiVolume::fixed(SIZE));
    }
    app.run_until_ready(MAX_FRAMES)?;
    if has_volume {
        render::never_pause(&mut app)?;
    }
    let report = *app.world().resource::<VoxelGiReport>();
    let row = TimeRow {
        scene: format!("triangles_{}", report.triangles),
        setting: format!("trace {resolution}^3"),
        bytes: Some(report.memory),
        ..TimeRow::default()
    };
    Ok((app, row))
}

fn spawn_spheres(world: &mut World, triangles: u32) {
    // A sphere of 2 n sectors and n stacks has 4 n (n - 1) triangles.
    let each = triangles as f32 / SPHERES.pow(3) as f32;
    let stacks = ((each / 4.0).sqrt() + 0.5).round().max(2.0) as u32;
    let step = SIZE / SPHERES as f32;
    let mesh = Sphere::new(0.35 * step).mesh().uv(2 * stacks, stacks);
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    let material = world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial::from(Color::srgb(0.8, 0.6, 0.4)));
    for index in 0..SPHERES.pow(3) {
        let cell = UVec3::new(
            index % SPHERES,
            index / SPHERES % SPHERES,
            index / SPHERES.pow(2),
        );
        let at = (cell.as_vec3() + 0.5) * step - 0.5 * SIZE;
        world.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(at),
        ));
    }
    world.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

//! Small scenes for tests: a floor, a wall, a light.

use bevy::{
    camera::{Exposure, visibility::RenderLayers},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings, LabTarget, TargetFormat};
use bevy_voxel_gi::{Sky, VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume};

use crate::support::pool::{Borrowed, Pool};

/// Edge of the picture in pixels.
pub const SIZE: u32 = 32;

/// Voxels along an edge of a volume, unless a test says otherwise.
pub const RESOLUTION: u32 = 16;

static APPS: Pool = Pool::new(|| build(|_| ()), begin);

/// An app with the plugin and a camera that sees 4 m x 4 m of the plane y = 0 from straight above,
/// +X to the right and -Z up, at an exposure of 1.
pub fn app() -> Borrowed {
    APPS.app()
}

/// The same with more in it, for this test alone.
pub fn app_with(more: impl FnOnce(&mut App)) -> HeadlessApp {
    let mut app = build(more);
    begin(app.world_mut());
    app
}

/// The same on a device with these limits.
pub fn app_within(limits: wgpu::Limits) -> HeadlessApp {
    let settings = HeadlessSettings {
        constrained_limits: Some(limits),
        ..picture_settings()
    };
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(VoxelGiPlugin)
            .add_observer(see_what_is_hidden);
    })
    .expect("no adapter");
    begin(app.world_mut());
    app
}

/// The same, where frames do not wait for pipelines.
pub fn asynchronous_app() -> HeadlessApp {
    let settings = HeadlessSettings {
        compiles_in_background: true,
        ..picture_settings()
    };
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(VoxelGiPlugin);
    })
    .expect("no adapter");
    begin(app.world_mut());
    app
}

fn picture_settings() -> HeadlessSettings {
    HeadlessSettings {
        format: TargetFormat::Float32,
        ..HeadlessSettings::with_size(SIZE, SIZE)
    }
}

fn build(more: impl FnOnce(&mut App)) -> HeadlessApp {
    HeadlessApp::new(picture_settings(), |app| {
        app.add_plugins(VoxelGiPlugin)
            .add_observer(see_what_is_hidden);
        more(app);
    })
    .expect("no adapter")
}

/// The layers of a mesh that cameras do not see and volumes do.
pub fn hidden() -> RenderLayers {
    RenderLayers::layer(5)
}

/// Volumes without layers of their own have those of cameras and of what is hidden from them.
fn see_what_is_hidden(
    added: On<Add<VoxelGiVolume>>,
    with_layers: Query<(), With<RenderLayers>>,
    mut commands: Commands,
) {
    if !with_layers.contains(added.entity) {
        let layers = RenderLayers::default().union(&hidden());
        commands.entity(added.entity).insert(layers);
    }
}

fn begin(world: &mut World) {
    world.insert_resource(GlobalAmbientLight::NONE);
    world.insert_resource(ClearColor(Color::BLACK));
    world.insert_resource(VoxelGiSettings {
        resolution: RESOLUTION,
        ..default()
    });
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((
        Camera3d::default(),
        bevy::camera::Hdr,
        target,
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        Exposure {
            ev100: -(1.2_f32.log2()),
        },
        Projection::from(OrthographicProjection {
            scaling_mode: bevy::camera::ScalingMode::Fixed {
                width: 4.0,
                height: 4.0,
            },
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 3.9, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z),
    ));
}

/// The settings of all volumes.
pub fn settings(world: &mut World) -> Mut<'_, VoxelGiSettings> {
    world.resource_mut()
}

/// A small volume of 4 m around the origin.
pub fn small_volume() -> VoxelGiVolume {
    VoxelGiVolume::fixed(4.0)
}

/// The same under a uniform sky.
pub fn under_sky(radiance: f32) -> VoxelGiVolume {
    VoxelGiVolume {
        sky: Some(Sky::uniform(LinearRgba::rgb(radiance, radiance, radiance))),
        ..small_volume()
    }
}

/// A material without gloss that reflects this share of light.
pub fn matt(world: &mut World, albedo: f32) -> Handle<StandardMaterial> {
    world
        .resource_mut::<Assets<StandardMaterial>>()
        .add(StandardMaterial {
            base_color: LinearRgba::rgb(albedo, albedo, albedo).into(),
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })
}

/// A dark box.
pub fn block(world: &mut World, center: Vec3, size: Vec3) -> Entity {
    block_of(world, 0.2, center, size)
}

/// A box that reflects this share of light.
pub fn block_of(world: &mut World, albedo: f32, center: Vec3, size: Vec3) -> Entity {
    let material = matt(world, albedo);
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::from_size(size));
    world
        .spawn((
            Mesh3d(mesh),
            MeshMaterial3d(material),
            Transform::from_translation(center),
        ))
        .id()
}

/// A white floor whose top is at y = 0.
pub fn floor(world: &mut World) -> Entity {
    block_of(
        world,
        1.0,
        Vec3::new(0.0, -0.25, 0.0),
        Vec3::new(3.8, 0.5, 3.8),
    )
}

/// The light at a place of the floor: mean of 3 x 3 pixels, x and z in metres.
pub fn at(picture: &[Vec3], x: f32, z: f32) -> Vec3 {
    let pixel = |v: f32| ((v + 2.0) / 4.0 * SIZE as f32).floor() as i32;
    let (column, row) = (pixel(x), pixel(z));
    let mut sum = Vec3::ZERO;
    for dy in -1..=1 {
        for dx in -1..=1 {
            sum += picture[((row + dy) * SIZE as i32 + column + dx) as usize];
        }
    }
    sum / 9.0
}

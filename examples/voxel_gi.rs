//! A room in which light bounces. The sun comes in by a window, and everything else is light of the walls.
//!
//! Space: light on and off. 1, 2, 3: voxels of 1 m, 1/2 m, 1/4 m. P: test their
//! visibility for each pixel. V: show them.

mod common;

use bevy::{camera::Exposure, camera_controller::free_camera::FreeCamera, prelude::*};
use bevy_voxel_gi::{
    DebugField, Receiver, Sky, VoxelGiDebug, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings,
    VoxelGiVolume,
};

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), VoxelGiPlugin))
        // Bevy's ambient light stands for the light that is computed here.
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb(0.6, 0.75, 0.9)))
        .add_systems(Startup, spawn)
        .add_systems(Update, (move_lift, switch, describe))
        .run()
}

#[derive(Component)]
struct Lift;

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // A cube of 12 m in which light bounces, and the light that comes in from outside of it, in cd/m².
    commands.spawn((
        VoxelGiVolume {
            sky: Some(Sky::uniform(LinearRgba::rgb(1500.0, 2200.0, 3500.0))),
            ..VoxelGiVolume::fixed(12.0)
        },
        Transform::from_xyz(0.0, 2.0, 0.0),
    ));
    commands.spawn((
        DirectionalLight {
            illuminance: 60_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(6.0, 7.0, 2.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Exposure { ev100: 11.0 },
        Transform::from_xyz(-2.2, 2.0, 4.4).looking_at(Vec3::new(0.4, 1.4, -1.0), Vec3::Y),
    ));

    let [white, red, green] = [
        Color::srgb(0.85, 0.85, 0.82),
        Color::srgb(0.8, 0.12, 0.08),
        Color::srgb(0.15, 0.6, 0.12),
    ]
    .map(|color| materials.add(color));
    // Floor, ceiling, the walls at the left, at the back and in front, and the right one with a window.
    let mut block = |center: [f32; 3], size: [f32; 3], material: &Handle<StandardMaterial>| {
        commands
            .spawn((
                Mesh3d(meshes.add(Cuboid::from_size(size.into()))),
                MeshMaterial3d(material.clone()),
                Transform::from_translation(center.into()),
            ))
            .id()
    };
    block([0.0, -0.25, 0.0], [7.0, 0.5, 11.0], &white);
    block([0.0, 4.25, 0.0], [7.0, 0.5, 11.0], &white);
    block([-3.25, 2.0, 0.0], [0.5, 4.0, 11.0], &red);
    block([0.0, 2.0, -5.25], [7.0, 4.0, 0.5], &white);
    block([0.0, 2.0, 5.25], [7.0, 4.0, 0.5], &white);
    block([3.25, 0.4, 0.0], [0.5, 0.8, 11.0], &green);
    block([3.25, 3.6, 0.0], [0.5, 0.8, 11.0], &green);
    block([3.25, 2.0, -3.5], [0.5, 2.4, 4.0], &green);
    block([3.25, 2.0, 3.5], [0.5, 2.4, 4.0], &green);
    block([-1.2, 0.5, -2.6], [1.0, 1.0, 1.0], &white);
    let lift = block([1.0, 0.9, -3.2], [1.2, 1.8, 1.2], &white);
    commands.entity(lift).insert(Lift);
}

/// Lights and meshes may change in every frame.
fn move_lift(mut lift: Single<&mut Transform, With<Lift>>, time: Res<Time>) {
    lift.translation.y = 1.5 - 0.6 * (0.5 * time.elapsed_secs()).cos();
}

fn switch(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<VoxelGiSettings>,
    mut visibility: Single<&mut Visibility, With<VoxelGiVolume>>,
    camera: Single<(Entity, Has<VoxelGiDebug>), With<Camera3d>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        visibility.toggle_visible_hidden();
    }
    for (key, resolution) in [
        (KeyCode::Digit1, 12),
        (KeyCode::Digit2, 24),
        (KeyCode::Digit3, 48),
    ] {
        if keys.just_pressed(key) {
            settings.resolution = resolution;
        }
    }
    if keys.just_pressed(KeyCode::KeyP) {
        settings.receiver = match settings.receiver {
            Receiver::Interpolated => Receiver::PerPixel,
            Receiver::PerPixel => Receiver::Interpolated,
        };
    }
    let (camera, shows_voxels) = *camera;
    if keys.just_pressed(KeyCode::KeyV) {
        let mut camera = commands.entity(camera);
        if shows_voxels {
            camera.remove::<VoxelGiDebug>();
        } else {
            camera.insert(VoxelGiDebug {
                field: DebugField::Radiance,
            });
        }
    }
}

fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    volume: Single<(&VoxelGiVolume, &Visibility)>,
    settings: Res<VoxelGiSettings>,
    report: Res<VoxelGiReport>,
) {
    let (volume, visibility) = *volume;
    let state = if *visibility == Visibility::Hidden {
        "off"
    } else {
        "on"
    };
    caption.0 = format!(
        "light that bounces: {state} (Space)\nvoxels of {:.2} m (1, 2, 3), {:?} (P), show them (V)\n{:.1} MB",
        volume.voxel_size(&settings),
        settings.receiver,
        report.memory as f64 / 1e6,
    );
}

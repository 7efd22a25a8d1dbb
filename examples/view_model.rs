//! A world and the arm of its player, each with a camera, in one compact frame buffer.
//!
//! 1: `Exact`. 2: `Compact`. M: multisampling.

mod common;

use bevy::{
    camera::{Hdr, visibility::RenderLayers},
    light::NotShadowCaster,
    prelude::*,
};
use bevy_ycocg_fb::{FrameBufferQuality, FrameBufferReport, YCoCgFrameBufferPlugin};

/// The layer of the arm, which the camera of the world does not show.
const ARM: RenderLayers = RenderLayers::layer(1);

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), YCoCgFrameBufferPlugin))
        .add_systems(Startup, spawn)
        .add_systems(Update, (sway, switch, describe))
        .run()
}

#[derive(Component)]
struct Arm;

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // The quality belongs to the camera of the world. The one on top draws on its picture and takes its format.
    commands.spawn((
        Camera3d::default(),
        Hdr,
        FrameBufferQuality::Compact,
        Transform::from_xyz(0.0, 1.7, 6.0).looking_at(Vec3::new(0.0, 1.0, 0.0), Vec3::Y),
        children![
            (
                Camera3d::default(),
                Camera {
                    order: 1,
                    clear_color: ClearColorConfig::None,
                    ..default()
                },
                Hdr,
                Projection::from(PerspectiveProjection {
                    fov: 70_f32.to_radians(),
                    ..default()
                }),
                ARM,
            ),
            (
                Arm,
                Mesh3d(meshes.add(Cuboid::new(0.12, 0.12, 0.6))),
                MeshMaterial3d(materials.add(Color::srgb(0.75, 0.55, 0.4))),
                Transform::from_xyz(0.25, -0.25, -0.6),
                ARM,
                NotShadowCaster,
            )
        ],
    ));
    commands.spawn((
        PointLight {
            intensity: 800_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(2.0, 5.0, 4.0),
        // It lights both.
        RenderLayers::layer(0).with(1),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(30.0, 30.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.3, 0.35, 0.3))),
    ));
    let pillar = meshes.add(Cylinder::new(0.4, 3.0));
    for (x, hue) in [(-3.0, 0.0), (0.0, 120.0), (3.0, 240.0)] {
        commands.spawn((
            Mesh3d(pillar.clone()),
            MeshMaterial3d(materials.add(Color::hsl(hue, 0.8, 0.5))),
            Transform::from_xyz(x, 1.5, -1.0),
        ));
    }
}

fn sway(mut arm: Single<&mut Transform, With<Arm>>, time: Res<Time>) {
    arm.translation.y = -0.25 + 0.02 * (3.0 * time.elapsed_secs()).sin();
}

fn switch(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    world: Single<Entity, With<FrameBufferQuality>>,
    cameras: Query<&mut Msaa, With<Camera3d>>,
) {
    for (key, quality) in [
        (KeyCode::Digit1, FrameBufferQuality::Exact),
        (KeyCode::Digit2, FrameBufferQuality::Compact),
    ] {
        if keys.just_pressed(key) {
            commands.entity(*world).insert(quality);
        }
    }
    if keys.just_pressed(KeyCode::KeyM) {
        for mut msaa in cameras {
            *msaa = match *msaa {
                Msaa::Off => Msaa::Sample4,
                _ => Msaa::Off,
            };
        }
    }
}

fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    world: Single<(&FrameBufferReport, &Msaa)>,
) {
    let (report, msaa) = *world;
    caption.0 = format!(
        "{:?} (1, 2), {}x (M): {:.1} MB of colours",
        report.state,
        msaa.samples(),
        report.memory.total() as f64 / 1e6,
    );
}

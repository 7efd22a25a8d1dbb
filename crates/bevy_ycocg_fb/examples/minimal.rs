//! A camera with `Hdr` whose colours take 4 bytes a sample in place of 8.

use bevy::{camera::Hdr, prelude::*};
use bevy_ycocg_fb::{FrameBufferQuality, YCoCgFrameBufferPlugin};

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, YCoCgFrameBufferPlugin))
        .add_systems(Startup, spawn)
        .run();
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        Hdr,
        FrameBufferQuality::Compact,
        Transform::from_xyz(0.0, 1.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::default())),
        MeshMaterial3d(materials.add(Color::srgb(0.9, 0.4, 0.1))),
    ));
}

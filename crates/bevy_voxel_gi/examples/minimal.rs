//! A red wall and a box in light that bounces.

use bevy::{color::palettes::css, prelude::*};
use bevy_voxel_gi::{VoxelGiPlugin, VoxelGiVolume};

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, VoxelGiPlugin))
        .add_systems(Startup, spawn)
        .run();
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    // Light bounces within 64 m of the camera.
    commands.spawn(VoxelGiVolume::default());
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(2.0, 2.5, 6.0).looking_at(Vec3::Y, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(4.0, 5.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    for (center, size, color) in [
        ([0.0, -0.25, 0.0], [8.0, 0.5, 8.0], Color::WHITE),
        ([-2.0, 1.5, 0.0], [0.5, 3.0, 8.0], css::RED.into()),
        ([0.0, 0.5, 0.0], [1.0, 1.0, 1.0], Color::WHITE),
    ] {
        commands.spawn((
            Mesh3d(meshes.add(Cuboid::from_size(size.into()))),
            MeshMaterial3d(materials.add(color)),
            Transform::from_translation(center.into()),
        ));
    }
}

//! What the cases share: one GPU test at a time and a small scene.

pub mod compose;
pub mod compute;

use std::sync::{Mutex, MutexGuard, PoisonError};

use bevy::prelude::*;
use bevy_frugal_lab::headless::LabTarget;

static GPU: Mutex<()> = Mutex::new(());

/// Holds the GPU: Bevy apps run one after the other, as each wants every core.
pub fn gpu() -> MutexGuard<'static, ()> {
    GPU.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A cube, lit from the front left, that turns a radian a second.
pub fn lit_cube(app: &mut App) {
    app.add_systems(Startup, spawn_cube)
        .add_systems(Update, turn);
}

#[derive(Component)]
struct Turning;

fn spawn_cube(
    mut commands: Commands,
    target: Res<LabTarget>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        target.0.clone(),
        Transform::from_xyz(0.0, 1.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(-1.0, 1.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Turning,
        Mesh3d(meshes.add(Cuboid::default())),
        MeshMaterial3d(materials.add(Color::srgb(0.8, 0.3, 0.1))),
    ));
}

fn turn(time: Res<Time>, mut cubes: Query<&mut Transform, With<Turning>>) {
    for mut transform in &mut cubes {
        transform.rotation = Quat::from_rotation_y(time.elapsed_secs());
    }
}

//! Helpers that several test modules share.

pub mod compute;
pub mod pool;

use std::{
    thread,
    time::{Duration, Instant},
};

use bevy::prelude::*;
pub use bevy_frugal_lab::{
    compose,
    testing::{Gpu, gpu, gpu_alone, logs, skipped},
};
use bevy_frugal_lab::{
    compose::Composer,
    headless::{HeadlessApp, LabTarget},
};

/// A composer with the shaders of an app once they are loaded, which other threads do: when none has come for a while.
pub fn composer(app: &mut HeadlessApp) -> Composer {
    let mut known = 0;
    let mut since = Instant::now();
    while since.elapsed() < Duration::from_millis(1000) {
        app.render_frames(1).expect("a frame");
        let count = app.world().resource::<Assets<Shader>>().len();
        if count != known {
            known = count;
            since = Instant::now();
        }
        thread::sleep(Duration::from_millis(5));
    }
    Composer::new(app.world())
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

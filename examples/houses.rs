//! Two houses, each with a volume of fine voxels, in a coarse one for the street.
//!
//! 1, 2: the volume of a house comes and goes. Space: all light that bounces, on and off.

mod common;

use bevy::{camera::Exposure, camera_controller::free_camera::FreeCamera, prelude::*};
use bevy_voxel_gi::{Sky, VoxelGiPlugin, VoxelGiVolume};

const HOUSES: [Vec3; 2] = [Vec3::new(-6.0, 0.0, 0.0), Vec3::new(6.0, 0.0, 0.0)];

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), VoxelGiPlugin))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb(0.6, 0.75, 0.9)))
        .add_systems(Startup, spawn)
        .add_systems(Update, (switch, describe))
        .run()
}

/// The number of a house.
#[derive(Component)]
struct House(usize);

/// A pixel is lit by the smallest volume around it, and rays that leave one go on in a larger one.
fn volume(size: f32) -> VoxelGiVolume {
    VoxelGiVolume {
        sky: Some(Sky::uniform(LinearRgba::rgb(2500.0, 3200.0, 4500.0))),
        ..VoxelGiVolume::fixed(size)
    }
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((volume(48.0), Transform::default()));
    commands.spawn((
        DirectionalLight {
            illuminance: 50_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 9.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Exposure { ev100: 11.3 },
        Transform::from_xyz(0.0, 5.0, 16.0).looking_at(Vec3::new(0.0, 1.0, 0.0), Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(40.0, 40.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.35, 0.4, 0.3))),
    ));
    let white = materials.add(Color::srgb(0.8, 0.78, 0.74));
    for (number, (center, color)) in HOUSES
        .into_iter()
        .zip([Color::srgb(0.8, 0.2, 0.1), Color::srgb(0.1, 0.3, 0.8)])
        .enumerate()
    {
        let colored = materials.add(color);
        commands.spawn((
            House(number),
            volume(8.0),
            Transform::from_translation(center + 2.0 * Vec3::Y),
        ));
        // Walls at the sides and at the back, a roof, and a front with a large opening.
        for (at, size, material) in [
            ([-3.0, 2.0, 0.0], [0.3, 4.0, 6.0], &colored),
            ([3.0, 2.0, 0.0], [0.3, 4.0, 6.0], &white),
            ([0.0, 2.0, -3.0], [6.3, 4.0, 0.3], &white),
            ([0.0, 4.1, 0.0], [6.6, 0.3, 6.6], &white),
            ([0.0, 3.4, 3.0], [6.3, 1.2, 0.3], &white),
            ([-1.0, 0.8, -1.0], [1.2, 1.6, 1.2], &white),
        ] {
            commands.spawn((
                Mesh3d(meshes.add(Cuboid::from_size(size.into()))),
                MeshMaterial3d(material.clone()),
                Transform::from_translation(center + Vec3::from(at)),
            ));
        }
    }
}

fn switch(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    fine: Query<(Entity, &House)>,
    mut all: Query<&mut Visibility, With<VoxelGiVolume>>,
) {
    for (number, key) in [KeyCode::Digit1, KeyCode::Digit2].into_iter().enumerate() {
        if keys.just_pressed(key) {
            match fine.iter().find(|(_, house)| house.0 == number) {
                Some((volume, _)) => commands.entity(volume).despawn(),
                None => {
                    let center = Transform::from_translation(HOUSES[number] + 2.0 * Vec3::Y);
                    commands.spawn((House(number), volume(8.0), center));
                }
            }
        }
    }
    if keys.just_pressed(KeyCode::Space) {
        for mut visibility in &mut all {
            visibility.toggle_visible_hidden();
        }
    }
}

fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    volumes: Query<&Visibility, With<VoxelGiVolume>>,
) {
    let shown = volumes
        .iter()
        .filter(|&&visibility| visibility != Visibility::Hidden)
        .count();
    caption.0 = format!("volumes: {shown} (1, 2, Space)");
}

//! A village under its own sky: light bounces around the camera, wherever it is, without a setting.
//!
//! 1, 2, 3: in the street, in a house, over the roofs. 4: a flight through all of them. Space: light on and off.

mod common;

use bevy::{
    camera::Exposure, camera_controller::free_camera::FreeCamera, light::Skybox, prelude::*,
};
use bevy_voxel_gi::{VoxelGiPlugin, VoxelGiVolume};

/// Positions and targets of the camera.
const VIEWS: [[Vec3; 2]; 3] = [
    [Vec3::new(0.5, 1.7, 24.0), Vec3::new(-1.5, 2.2, 0.0)],
    [Vec3::new(-10.2, 1.6, 9.6), Vec3::new(-6.0, 1.2, 6.5)],
    [Vec3::new(24.0, 19.0, 40.0), Vec3::ZERO],
];

/// The flight, at 4 m/s: down the street, in at a door, out at a window, and back over the roofs.
const FLIGHT: [Vec3; 11] = [
    Vec3::new(0.5, 1.7, 24.0),
    Vec3::new(0.0, 1.7, 10.0),
    Vec3::new(-3.0, 1.6, 5.3),
    Vec3::new(-5.0, 1.5, 5.1),
    Vec3::new(-7.6, 1.6, 5.6),
    Vec3::new(-7.2, 1.6, 7.6),
    Vec3::new(-5.0, 1.55, 8.15),
    Vec3::new(-1.0, 2.5, 7.0),
    Vec3::new(5.0, 9.0, -6.0),
    Vec3::new(-9.0, 12.0, -22.0),
    Vec3::new(-9.0, 9.0, 20.0),
];

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), VoxelGiPlugin))
        .add_systems(Startup, spawn)
        .add_systems(Update, switch)
        .run()
}

fn view([eye, target]: [Vec3; 2]) -> Transform {
    Transform::from_translation(eye).looking_at(target, Vec3::Y)
}

fn spawn(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn(VoxelGiVolume::default());
    // The environment map lights the voxels, what is beyond them, and what is glossy.
    let sky = EnvironmentMapLight::hemispherical_gradient(
        &mut images,
        Color::linear_rgb(0.25, 0.45, 1.0),
        Color::linear_rgb(0.75, 0.85, 1.0),
        Color::linear_rgb(0.3, 0.27, 0.2),
    )
    .with_intensity(5000.0);
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Exposure { ev100: 12.3 },
        Skybox {
            image: Some(sky.specular_map.clone()),
            brightness: sky.intensity,
            ..default()
        },
        sky,
        view(VIEWS[0]),
    ));
    commands.spawn((
        DirectionalLight {
            illuminance: 60_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(7.0, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let cube = meshes.add(Cuboid::default());
    let mut spawn_box = |center: Vec3, size: Vec3, material: &Handle<StandardMaterial>| {
        commands.spawn((
            Mesh3d(cube.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(center).with_scale(size),
        ));
    };
    let ground = materials.add(Color::srgb(0.4, 0.42, 0.3));
    let roof = materials.add(Color::srgb(0.5, 0.2, 0.15));
    let plaster = [[0.85, 0.8, 0.7], [0.8, 0.45, 0.3], [0.55, 0.7, 0.8]]
        .map(|color| materials.add(Color::srgb_from_array(color)));
    spawn_box(Vec3::Y * -0.5, Vec3::new(160.0, 1.0, 160.0), &ground);
    for number in 0..16_u8 {
        let side = if number % 2 == 0 { -1.0 } else { 1.0 };
        let center = Vec3::new(side * 8.0, 0.0, 35.0 - 9.5 * f32::from(number / 2));
        let walls = &plaster[usize::from(number) % 3];
        // Towards the street: a wall with a door and a window, which are holes between five boxes.
        let front = -side * 3.0;
        for (at, size, material) in [
            ([-front, 1.5, 0.0], [0.3, 3.0, 7.0], walls),
            ([0.0, 1.5, -3.35], [5.7, 3.0, 0.3], walls),
            ([0.0, 1.5, 3.35], [5.7, 3.0, 0.3], walls),
            ([front, 1.5, -2.75], [0.3, 3.0, 1.5], walls),
            ([front, 1.5, 0.0], [0.3, 3.0, 1.6], walls),
            ([front, 1.5, 3.0], [0.3, 3.0, 1.0], walls),
            ([front, 2.6, 0.0], [0.3, 0.8, 7.0], walls),
            ([front, 0.45, 1.65], [0.3, 0.9, 1.7], walls),
            ([0.0, 3.15, 0.0], [7.0, 0.3, 7.8], &roof),
            ([-0.4 * front, 0.4, 1.5], [1.6, 0.8, 1.0], &roof),
        ] {
            spawn_box(center + Vec3::from(at), size.into(), material);
        }
    }
}

fn switch(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut flight: Local<Option<f32>>,
    mut camera: Single<&mut Transform, With<FreeCamera>>,
    mut volume: Single<&mut Visibility, With<VoxelGiVolume>>,
    mut caption: Single<&mut Text, With<common::Caption>>,
) -> Result {
    let places = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3];
    for (key, place) in places.into_iter().zip(VIEWS) {
        if keys.just_pressed(key) {
            **camera = view(place);
            *flight = None;
        }
    }
    if keys.just_pressed(KeyCode::Digit4) {
        *flight = Some(0.0);
    }
    if let Some(at) = &mut *flight {
        let curve = CubicCardinalSpline::new_catmull_rom(FLIGHT).to_curve_cyclic()?;
        let end = FLIGHT.len() as f32;
        *at = (*at + 4.0 * time.delta_secs() / curve.velocity(*at).length()) % end;
        **camera = view([curve.position(*at), curve.position((*at + 0.2) % end)]);
    }
    if keys.just_pressed(KeyCode::Space) {
        volume.toggle_visible_hidden();
    }
    let light = match **volume {
        Visibility::Hidden => "environment map alone",
        _ => "light that bounces",
    };
    caption.0 = format!("{light} (Space)\nplaces: 1, 2, 3; flight: 4");
    Ok(())
}

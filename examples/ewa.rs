//! A tiled floor that ends at the horizon: mip levels, anisotropy, or ellipses.
//!
//! 1: Bevy alone. 2: mip levels and 16x anisotropy. 3: five probes. 4: the ellipse, exact. M: move.

mod common;

use bevy::{
    asset::RenderAssetUsages,
    camera_controller::free_camera::FreeCamera,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_ewa::{AllMaterials, EwaMethod, EwaPlugin, EwaProbes, EwaSettings};

fn main() -> AppExit {
    App::new()
        // `EwaPlugin::default()` is what most games want: mip levels and 16x anisotropy on everything.
        .add_plugins((common::plugins(), EwaPlugin::elliptical()))
        .add_systems(Startup, spawn)
        .add_systems(Update, (switch, travel, describe))
        .run()
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    // Textures of the game stay as they are, whether loaded or made here: without mip levels.
    let tiles = images.add(tiles());
    let material = materials.add(StandardMaterial {
        base_color_texture: Some(tiles),
        perceptual_roughness: 1.0,
        uv_transform: bevy::math::Affine2::from_scale(Vec2::splat(100.0)),
        ..default()
    });
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(200.0, 200.0))),
        MeshMaterial3d(material.clone()),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::new(Vec3::X, Vec2::splat(100.0)))),
        MeshMaterial3d(material),
        Transform::from_xyz(-4.0, 0.0, 0.0),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(3.0, 5.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Transform::from_xyz(0.0, 1.2, 90.0).looking_at(Vec3::new(4.0, 0.0, 60.0), Vec3::Y),
    ));
    commands.insert_resource(ClearColor(Color::srgb(0.5, 0.65, 0.8)));
}

/// Tiles of two colours with thin joints.
fn tiles() -> Image {
    const SIZE: u32 = 256;
    let texel = |x: u32, y: u32| -> [u8; 4] {
        let is_joint = x % 64 < 4 || y % 64 < 4;
        match (is_joint, (x / 64 + y / 64) % 2) {
            (true, _) => [40, 36, 34, 255],
            (_, 0) => [226, 218, 200, 255],
            _ => [132, 60, 44, 255],
        }
    };
    let data = (0..SIZE * SIZE)
        .flat_map(|i| texel(i % SIZE, i / SIZE))
        .collect();
    Image::new(
        Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    )
}

fn switch(keys: Res<ButtonInput<KeyCode>>, mut all: ResMut<AllMaterials>) {
    let approximate = EwaMethod::Approximate {
        probes: EwaProbes::Five,
    };
    for (key, method) in [
        (KeyCode::Digit1, None),
        (KeyCode::Digit2, Some(EwaMethod::Anisotropic)),
        (KeyCode::Digit3, Some(approximate)),
        (KeyCode::Digit4, Some(EwaMethod::Linear)),
    ] {
        if keys.just_pressed(key) {
            all.0 = method.map(EwaSettings::with_method);
        }
    }
}

/// Aliasing is worst where the camera moves.
fn travel(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut moves: Local<bool>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    *moves ^= keys.just_pressed(KeyCode::KeyM);
    if *moves {
        camera.translation.z -= 2.0 * time.delta_secs();
    }
}

fn describe(mut caption: Single<&mut Text, With<common::Caption>>, all: Res<AllMaterials>) {
    let method = match all.0 {
        None => "Bevy alone: no mip levels".into(),
        Some(settings) => format!("{:?}", settings.method),
    };
    caption.0 = format!("{method} (1, 2, 3, 4)\nmove (M)");
}

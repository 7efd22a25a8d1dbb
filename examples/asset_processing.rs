//! A photo that Bevy's asset processor makes a wavelet texture.
//!
//! The file `source_assets/bricks.jpg.meta` names the processor and its settings. What it writes is in
//! `imported_assets`, and is written again when the photo or the settings change. A released game needs only that folder,
//! without the features `asset_processor` of Bevy and `encode` of the plugin.

mod common;

use bevy::{camera_controller::free_camera::FreeCamera, prelude::*};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletStandardMaterial, WaveletTexPlugin, WaveletTexture,
};

fn main() -> AppExit {
    let assets = AssetPlugin {
        mode: AssetMode::Processed,
        file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/examples/source_assets").into(),
        processed_file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/imported_assets").into(),
        ..default()
    };
    App::new()
        .add_plugins((common::plugins().set(assets), WaveletTexPlugin))
        .add_systems(Startup, spawn)
        .add_systems(Update, describe)
        .run()
}

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Transform::from_xyz(0.0, 0.0, 3.2),
    ));
    commands.spawn((
        PointLight {
            intensity: 400_000.0,
            ..default()
        },
        Transform::from_xyz(1.0, 1.0, 1.5),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Rectangle::new(3.0, 3.0))),
        MeshMaterial3d(materials.add(WaveletStandardMaterial {
            base: StandardMaterial {
                perceptual_roughness: 0.8,
                ..default()
            },
            extension: WaveletExtension {
                // The name of the photo, and the type of what it becomes.
                base_color: Some(assets.load("bricks.jpg")),
                ..default()
            },
        })),
    ));
}

/// The first start waits for the encoder.
fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    textures: Res<Assets<WaveletTexture>>,
) {
    let Some((_, texture)) = textures.iter().next() else {
        return;
    };
    let pixels = f64::from(texture.size[0] * texture.size[1]);
    caption.0 = format!(
        "bricks.jpg is a texture of {} x {} pixels, {:.2} bits each with mip levels",
        texture.size[0],
        texture.size[1],
        8.0 * texture.gpu_bytes as f64 / pixels,
    );
}

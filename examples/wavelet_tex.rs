//! A brick wall of two wavelet textures beside one of the images that they were encoded from.
//!
//! ```sh
//! wavelet-tex encode bricks.jpg bricks.wtex
//! wavelet-tex encode bricks_normal.png bricks_normal.wtex
//! ```
//!
//! 1: nearest. 2: bilinear. 3: trilinear. 4: anisotropic.

mod common;

use bevy::{camera_controller::free_camera::FreeCamera, image::ImageLoaderSettings, prelude::*};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletTexPlugin, WaveletTexture,
};

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), WaveletTexPlugin))
        .add_systems(Startup, spawn)
        .add_systems(Update, (move_light, switch, describe))
        .run()
}

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut plain: ResMut<Assets<StandardMaterial>>,
    mut wavelet: ResMut<Assets<WaveletStandardMaterial>>,
) -> Result {
    // Normal maps need tangents, in Bevy's materials as in these.
    let wall = Mesh::from(Rectangle::new(3.0, 3.0)).with_generated_tangents()?;
    let wall = meshes.add(wall);
    let base = StandardMaterial {
        perceptual_roughness: 0.8,
        ..default()
    };
    commands.spawn((
        Mesh3d(wall.clone()),
        MeshMaterial3d(
            plain.add(StandardMaterial {
                base_color_texture: Some(assets.load("bricks.jpg")),
                normal_map_texture: Some(
                    assets
                        .load_builder()
                        .with_settings(|settings: &mut ImageLoaderSettings| {
                            settings.is_srgb = false;
                        })
                        .load("bricks_normal.png"),
                ),
                ..base.clone()
            }),
        ),
        Transform::from_xyz(-1.6, 0.0, 0.0),
    ));
    commands.spawn((
        Mesh3d(wall),
        MeshMaterial3d(wavelet.add(WaveletStandardMaterial {
            base,
            extension: WaveletExtension {
                base_color: Some(assets.load("bricks.wtex")),
                normal: Some(assets.load("bricks_normal.wtex")),
                ..default()
            },
        })),
        Transform::from_xyz(1.6, 0.0, 0.0),
    ));
    commands.spawn((
        PointLight {
            intensity: 400_000.0,
            ..default()
        },
        Transform::from_xyz(0.0, 1.0, 1.5),
    ));
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Transform::from_xyz(0.0, 0.0, 4.6),
    ));
    Ok(())
}

fn move_light(mut light: Single<&mut Transform, With<PointLight>>, time: Res<Time>) {
    light.translation.x = 2.0 * (0.5 * time.elapsed_secs()).sin();
}

fn switch(keys: Res<ButtonInput<KeyCode>>, mut materials: ResMut<Assets<WaveletStandardMaterial>>) {
    for (key, filter) in [
        (KeyCode::Digit1, WaveletFilter::Nearest),
        (KeyCode::Digit2, WaveletFilter::Bilinear),
        (KeyCode::Digit3, WaveletFilter::Trilinear),
        (KeyCode::Digit4, WaveletFilter::Anisotropic),
    ] {
        if keys.just_pressed(key) {
            for (_, material) in materials.iter_mut() {
                material.extension.filter = filter;
            }
        }
    }
}

/// What the textures take on the GPU, mip levels included.
fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    materials: Res<Assets<WaveletStandardMaterial>>,
    textures: Res<Assets<WaveletTexture>>,
) {
    let Some((_, material)) = materials.iter().next() else {
        return;
    };
    let pixels = |texture: &WaveletTexture| texture.size[0] * texture.size[1];
    let pixels: u32 = textures.iter().map(|(_, texture)| pixels(texture)).sum();
    let bytes: usize = textures.iter().map(|(_, texture)| texture.gpu_bytes).sum();
    caption.0 = format!(
        "left: 32 bits a pixel, right: {:.2} with mip levels\n{:?} (1, 2, 3, 4)",
        8.0 * bytes as f64 / f64::from(pixels.max(1)),
        material.extension.filter,
    );
}

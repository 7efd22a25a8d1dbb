//! A wall of two wavelet textures.
//!
//! ```sh
//! wavelet-tex encode wall.jpg assets/wall.wtex
//! wavelet-tex encode wall_normal.png assets/wall_normal.wtex
//! ```

use bevy::prelude::*;
use bevy_wavelet_tex::{WaveletExtension, WaveletStandardMaterial, WaveletTexPlugin};

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, WaveletTexPlugin))
        .add_systems(Startup, spawn)
        .run();
}

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) -> Result {
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 4.0)));
    commands.spawn((PointLight::default(), Transform::from_xyz(1.0, 1.0, 2.0)));
    // Normal maps need tangents.
    let wall = Mesh::from(Rectangle::new(4.0, 3.0)).with_generated_tangents()?;
    commands.spawn((
        Mesh3d(meshes.add(wall)),
        MeshMaterial3d(materials.add(WaveletStandardMaterial {
            base: StandardMaterial {
                perceptual_roughness: 0.9,
                ..default()
            },
            extension: WaveletExtension {
                base_color: Some(assets.load("wall.wtex")),
                normal: Some(assets.load("wall_normal.wtex")),
                ..default()
            },
        })),
    ));
    Ok(())
}

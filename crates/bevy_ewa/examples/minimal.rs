//! Mip levels and 16x anisotropy for all textures of a game.

use bevy::image::{ImageAddressMode, ImageSamplerDescriptor};
use bevy::{math::Affine2, prelude::*};
use bevy_ewa::EwaPlugin;

fn main() {
    // Tiles repeat, where Bevy's default is to clamp them.
    let mut default_sampler = ImageSamplerDescriptor::linear();
    default_sampler.set_address_mode(ImageAddressMode::Repeat);
    let plugins = DefaultPlugins.set(ImagePlugin { default_sampler });
    App::new()
        .add_plugins((plugins, EwaPlugin::default()))
        .add_systems(Startup, spawn)
        .run();
}

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 1.5, 20.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    // Any image in the folder `assets`: PNG and JPEG files have no mip levels.
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(40.0, 40.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color_texture: Some(assets.load("tiles.png")),
            uv_transform: Affine2::from_scale(Vec2::splat(20.0)),
            ..default()
        })),
    ));
}

//! All four plugins in one scene: a wall of wavelet textures and a floor of plain ones, which get mip levels and
//! anisotropy, in light that bounces, drawn into a compact frame buffer.
//!
//! 1: mip levels and anisotropy. 2: light that bounces. 3: the frame buffer.

mod common;

use bevy::{
    camera::{Exposure, Hdr},
    camera_controller::free_camera::FreeCamera,
    math::Affine2,
    post_process::bloom::Bloom,
    prelude::*,
};
use bevy_ewa::{AllMaterials, EwaPlugin};
use bevy_voxel_gi::{Sky, VoxelGiPlugin, VoxelGiVolume, VoxelMaterialPlugin};
use bevy_wavelet_tex::{WaveletExtension, WaveletStandardMaterial, WaveletTexPlugin};
use bevy_ycocg_fb::{FrameBufferQuality, FrameBufferReport, YCoCgFrameBufferPlugin};

fn main() -> AppExit {
    App::new()
        .add_plugins((
            common::plugins(),
            WaveletTexPlugin,
            EwaPlugin::default(),
            VoxelGiPlugin,
            YCoCgFrameBufferPlugin,
            // Light that bounces has the colours of wavelet textures.
            VoxelMaterialPlugin::<WaveletStandardMaterial>::default(),
        ))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb(0.6, 0.75, 0.9)))
        .add_systems(Startup, spawn)
        .add_systems(Update, (switch, describe))
        .run()
}

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut plain: ResMut<Assets<StandardMaterial>>,
    mut wavelet: ResMut<Assets<WaveletStandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Hdr,
        Bloom::NATURAL,
        Exposure { ev100: 11.5 },
        FrameBufferQuality::Compact,
        Transform::from_xyz(1.2, 1.6, 6.5).looking_at(Vec3::new(-0.4, 1.5, -4.0), Vec3::Y),
    ));
    commands.spawn((
        VoxelGiVolume {
            sky: Some(Sky::uniform(LinearRgba::rgb(2500.0, 3200.0, 4500.0))),
            ..VoxelGiVolume::fixed(20.0)
        },
        Transform::from_xyz(0.0, 2.0, -2.0),
    ));
    commands.spawn((
        DirectionalLight {
            illuminance: 70_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(7.0, 7.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));

    let base = StandardMaterial {
        perceptual_roughness: 0.9,
        uv_transform: Affine2::from_scale(Vec2::new(2.0, 9.0)),
        ..default()
    };
    let plain_bricks = plain.add(StandardMaterial {
        base_color_texture: Some(assets.load("bricks.jpg")),
        ..base.clone()
    });
    // The sides of a cuboid have their first coordinate upright.
    let turned =
        Affine2::from_scale(Vec2::new(9.0, 2.0)) * Affine2::from_angle(90_f32.to_radians());
    let wavelet_bricks = wavelet.add(WaveletStandardMaterial {
        base: StandardMaterial {
            uv_transform: turned,
            ..base
        },
        extension: WaveletExtension {
            base_color: Some(assets.load("bricks.wtex")),
            ..default()
        },
    });
    // A passage that is open to the sun at the right. Materials of both kinds may be in one scene.
    let block = |at: [f32; 3], size: [f32; 3], meshes: &mut Assets<Mesh>| {
        (
            Mesh3d(meshes.add(Cuboid::from_size(size.into()))),
            Transform::from_translation(at.into()),
        )
    };
    let wall = block([-2.8, 2.0, -2.0], [0.4, 4.0, 18.0], &mut meshes);
    commands.spawn((wall, MeshMaterial3d(wavelet_bricks)));
    let white = plain.add(Color::srgb(0.8, 0.8, 0.78));
    let red = plain.add(Color::srgb(0.8, 0.1, 0.05));
    let mut parts = vec![
        ([0.0, -0.2, -2.0], [6.0, 0.4, 18.0], &plain_bricks),
        ([0.0, 4.2, -2.0], [6.0, 0.4, 18.0], &plain_bricks),
        ([0.0, 2.0, -10.8], [6.0, 4.0, 0.4], &white),
        ([-1.4, 0.6, 0.0], [1.2, 1.2, 1.2], &red),
    ];
    parts.extend((0..6).map(|i| ([2.6, 2.0, 5.0 - 3.0 * i as f32], [0.5, 4.0, 0.5], &white)));
    for (at, size, material) in parts {
        let part = block(at, size, &mut meshes);
        commands.spawn((part, MeshMaterial3d(material.clone())));
    }
}

fn switch(
    keys: Res<ButtonInput<KeyCode>>,
    mut all: ResMut<AllMaterials>,
    mut volume: Single<&mut Visibility, With<VoxelGiVolume>>,
    mut quality: Single<&mut FrameBufferQuality>,
) {
    if keys.just_pressed(KeyCode::Digit1) {
        // Off if it is on, else on.
        all.0 = all.0.xor(AllMaterials::default().0);
    }
    if keys.just_pressed(KeyCode::Digit2) {
        volume.toggle_visible_hidden();
    }
    if keys.just_pressed(KeyCode::Digit3) {
        **quality = match **quality {
            FrameBufferQuality::Exact => FrameBufferQuality::Compact,
            _ => FrameBufferQuality::Exact,
        };
    }
}

fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    all: Res<AllMaterials>,
    volume: Single<&Visibility, With<VoxelGiVolume>>,
    camera: Single<&FrameBufferReport>,
) {
    let on = |is_on| if is_on { "on" } else { "off" };
    caption.0 = format!(
        "mip levels and anisotropy: {} (1)\nlight that bounces: {} (2)\nframe buffer: {:?} (3)",
        on(all.0.is_some()),
        on(**volume != Visibility::Hidden),
        camera.state,
    );
}

//! Spawns the camera, the light, the volume, the crate and the floor.

use bevy::{
    camera::{Hdr, RenderTarget},
    gltf::GltfAssetLabel,
    post_process::bloom::Bloom,
    prelude::*,
    world_serialization::WorldAssetRoot,
};
use bevy_voxel_gi::{VoxelGiSettings, VoxelGiVolume};
use bevy_wavelet_tex::{WaveletExtension, WaveletStandardMaterial};
use bevy_ycocg_fb::{FrameBufferQuality, YCoCgFrameBuffer};

use crate::headless::Target;

pub fn spawn(
    mut commands: Commands,
    target: Res<Target>,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        RenderTarget::Image(target.0.clone().into()),
        Hdr,
        Bloom::NATURAL,
        FrameBufferQuality::Packed(YCoCgFrameBuffer::default()),
        Transform::from_xyz(2.0, 1.6, 3.0).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.insert_resource(VoxelGiSettings {
        resolution: 16,
        ..default()
    });
    commands.spawn((VoxelGiVolume::default(), Transform::default()));
    commands.spawn((
        WorldAssetRoot(
            assets.load(GltfAssetLabel::Scene(0).from_asset("tests/game/assets/crate.gltf")),
        ),
        Transform::from_xyz(0.0, 0.5, 0.0),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(8.0, 8.0))),
        MeshMaterial3d(materials.add(WaveletStandardMaterial {
            base: StandardMaterial::default(),
            extension: WaveletExtension {
                base_color: Some(assets.load("examples/assets/bricks.wtex")),
                ..default()
            },
        })),
    ));
}

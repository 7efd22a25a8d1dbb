//! A small game: a glTF model on a floor, a sun with shadows, and all four plugins, added in another
//! order than in the lab. Headless: it draws some frames, and fails if anything logged an error, a plugin
//! did not do what it is for, or the picture is empty.

#[cfg(feature = "default")]
mod headless;

use bevy::prelude::*;
use bevy_ewa::EwaPlugin;
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::WaveletTexPlugin;
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

fn plugins(app: &mut App) {
    app.add_plugins((
        YCoCgFrameBufferPlugin,
        VoxelGiPlugin,
        WaveletTexPlugin,
        EwaPlugin::elliptical(),
    ));
}

#[cfg(feature = "default")]
fn main() -> AppExit {
    let mut app = App::new();
    headless::build(&mut app);
    plugins(&mut app);
    app.add_systems(Startup, scene::spawn).run()
}

/// With the fewest features it is enough that all compile together.
#[cfg(not(feature = "default"))]
fn main() {
    plugins(&mut App::new());
}

#[cfg(feature = "default")]
mod scene {
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

    use super::headless::Target;

    /// Spawns the camera, the light, the volume, the crate and the floor.
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
}

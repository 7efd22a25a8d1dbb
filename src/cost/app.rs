//! A configuration in an app: one quad with one material, one point light with shadows, one camera. So
//! each pass has one pipeline, and the pipelines of two configurations differ by the plugin only.

use bevy::{
    asset::RenderAssetUsages,
    camera::Hdr,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    light::IrradianceVolume,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_ewa::EwaPlugin;
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::WaveletTexPlugin;
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use super::{
    configurations::{Configuration, Kind},
    error::CostError,
    scene::Scene,
    skin::{SMALL_TEXTURE, Skin},
};
use crate::headless::{HeadlessApp, HeadlessSettings, LabTarget};

/// The app of a configuration, before its first frame.
///
/// # Errors
/// [`CostError::App`] where there is no adapter.
pub fn app(configuration: &Configuration, scene: Scene) -> Result<HeadlessApp, CostError> {
    let kind = &configuration.kind;
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(64, 64), |app| {
        add_plugin(app, kind);
    })?;
    let world = app.world_mut();
    spawn_camera(world, kind, scene);
    spawn_light(world, Vec3::new(1.0, 1.0, 2.0));
    let mesh = Mesh::from(Rectangle::default()).with_generated_tangents();
    let mesh = mesh.map_err(|error| CostError::Failed(error.to_string()))?;
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    let skin = Skin::new(world, kind, scene, SMALL_TEXTURE);
    skin.put_on(world.spawn(mesh));
    spawn_volume(world, kind);
    Ok(app)
}

/// A point light with shadows.
pub(super) fn spawn_light(world: &mut World, place: Vec3) {
    world.spawn((
        PointLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_translation(place),
    ));
}

/// The volume of light of a kind, if it has one.
pub(super) fn spawn_volume(world: &mut World, kind: &Kind) {
    match kind {
        Kind::Gi(settings, volume) => {
            world.insert_resource(settings.clone());
            world.spawn(volume.clone());
        }
        Kind::IrradianceVolume => {
            let voxels = irradiance(world);
            world.spawn((
                IrradianceVolume {
                    voxels,
                    intensity: 1.0,
                    ..default()
                },
                Transform::from_scale(Vec3::splat(16.0)),
            ));
        }
        _ => {}
    }
}

pub(super) fn add_plugin(app: &mut App, kind: &Kind) {
    match *kind {
        Kind::Bevy | Kind::IrradianceVolume => app,
        Kind::Ewa(settings) => app.add_plugins(EwaPlugin {
            all_materials: Some(settings),
        }),
        Kind::Wavelet(..) => app.add_plugins(WaveletTexPlugin),
        Kind::FrameBuffer(_) => app.add_plugins(YCoCgFrameBufferPlugin),
        Kind::Gi(..) => app.add_plugins(VoxelGiPlugin),
    };
}

pub(super) fn spawn_camera(world: &mut World, kind: &Kind, scene: Scene) {
    let target = world.resource::<LabTarget>().0.clone();
    let samples = if scene == Scene::Multisampled {
        Msaa::Sample4
    } else {
        Msaa::Off
    };
    let place = Transform::from_xyz(0.0, 0.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut camera = world.spawn((Camera3d::default(), target, samples, place));
    if scene != Scene::EightBits {
        camera.insert(Hdr);
    }
    match scene {
        Scene::Masked => {
            camera.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
        }
        Scene::Deferred => {
            camera.insert((DepthPrepass, DeferredPrepass));
        }
        _ => {}
    }
    if let Kind::FrameBuffer(quality) = *kind {
        camera.insert(quality);
    }
}

/// The smallest irradiance volume of Bevy: three sides and two directions of a voxel.
fn irradiance(world: &mut World) -> Handle<Image> {
    let size = Extent3d {
        width: 1,
        height: 2,
        depth_or_array_layers: 3,
    };
    let format = TextureFormat::Rgba16Float;
    let usages = RenderAssetUsages::RENDER_WORLD;
    let image = Image::new_fill(size, TextureDimension::D3, &[0; 8], format, usages);
    world.resource_mut::<Assets<Image>>().add(image)
}

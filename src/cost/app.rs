//! A configuration in an app: one quad with one material, one point light with shadows, one camera. So
//! each pass has one pipeline, and the pipelines of two configurations differ by the plugin only.

use bevy::{
    asset::RenderAssetUsages,
    camera::Hdr,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    light::IrradianceVolume,
    material::OpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_ewa::EwaPlugin;
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::{
    WaveletExtension, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin, WaveletTexture,
    codec::{
        encoder::encode_rgb8,
        image::{ColorSpace, Content},
        rate::Rate,
        settings::EncodeSettings,
    },
};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use super::{
    configurations::{Configuration, Kind},
    error::CostError,
    scene::Scene,
};
use crate::headless::{HeadlessApp, HeadlessSettings, LabTarget};

/// Side of the textures in pixels: it is in no shader.
const TEXTURE_SIZE: u32 = 16;

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
    world.spawn((
        PointLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.0, 1.0, 2.0),
    ));
    let mesh = Mesh::from(Rectangle::default()).with_generated_tangents();
    let mesh = mesh.map_err(|error| CostError::Failed(error.to_string()))?;
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    let skin = Skin::new(world, kind, scene);
    skin.put_on(world.spawn(mesh));
    match kind {
        Kind::Gi(volume) => {
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
    Ok(app)
}

pub(super) fn add_plugin(app: &mut App, kind: &Kind) {
    match *kind {
        Kind::Bevy | Kind::IrradianceVolume => app,
        Kind::Ewa(settings) => app.add_plugins(EwaPlugin {
            all_materials: Some(settings),
        }),
        Kind::Wavelet(..) => app.add_plugins(WaveletTexPlugin),
        Kind::Packed(_) => app.add_plugins(YCoCgFrameBufferPlugin),
        Kind::Gi(_) => app.add_plugins(VoxelGiPlugin),
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
    if let Kind::Packed(settings) = *kind {
        camera.insert(settings);
    }
}

/// A material of either type.
pub(super) enum Skin {
    Standard(Handle<StandardMaterial>),
    Wavelet(Handle<WaveletStandardMaterial>),
}

impl Skin {
    pub(super) fn new(world: &mut World, kind: &Kind, scene: Scene) -> Self {
        if let Kind::Wavelet(filter, rate) = *kind {
            return Self::Wavelet(wavelet_material(world, scene, filter, rate));
        }
        let material = material(world, scene, true);
        Self::Standard(
            world
                .resource_mut::<Assets<StandardMaterial>>()
                .add(material),
        )
    }

    pub(super) fn put_on(&self, mut mesh: EntityWorldMut) {
        match self {
            Self::Standard(material) => mesh.insert(MeshMaterial3d(material.clone())),
            Self::Wavelet(material) => mesh.insert(MeshMaterial3d(material.clone())),
        };
    }
}

/// A material with textures where `has_textures`, and with the factors that they need.
fn material(world: &mut World, scene: Scene, has_textures: bool) -> StandardMaterial {
    let mut images = world.resource_mut::<Assets<Image>>();
    let mut map =
        |wanted: bool, format| (wanted && has_textures).then(|| images.add(texture(format)));
    let (color, data) = (TextureFormat::Rgba8UnormSrgb, TextureFormat::Rgba8Unorm);
    let all = scene.has_five_maps();
    StandardMaterial {
        base_color_texture: map(true, color),
        emissive_texture: map(all, color),
        normal_map_texture: map(all, data),
        metallic_roughness_texture: map(all, data),
        occlusion_texture: map(all, data),
        emissive: if all {
            LinearRgba::WHITE
        } else {
            LinearRgba::BLACK
        },
        alpha_mode: if scene == Scene::Masked {
            AlphaMode::Mask(0.5)
        } else {
            AlphaMode::Opaque
        },
        opaque_render_method: if scene == Scene::Deferred {
            OpaqueRendererMethod::Deferred
        } else {
            OpaqueRendererMethod::Forward
        },
        ..default()
    }
}

fn texture(format: TextureFormat) -> Image {
    let size = Extent3d {
        width: TEXTURE_SIZE,
        height: TEXTURE_SIZE,
        depth_or_array_layers: 1,
    };
    let usages = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_fill(size, TextureDimension::D2, &[255; 4], format, usages);
    let mut sampler = ImageSamplerDescriptor::linear();
    sampler.set_address_mode(ImageAddressMode::Repeat);
    image.sampler = ImageSampler::Descriptor(sampler);
    image
}

fn wavelet_material(
    world: &mut World,
    scene: Scene,
    filter: bevy_wavelet_tex::WaveletFilter,
    rate: Rate,
) -> Handle<WaveletStandardMaterial> {
    let base = material(world, scene, false);
    let mut map = |wanted: bool, content, rate, color_space| {
        wanted.then(|| wavelet_texture(world, content, rate, color_space))
    };
    let all = scene.has_five_maps();
    let gray = Rate::usual(Content::Gray);
    let extension = WaveletExtension {
        base_color: map(true, Content::Color, rate, ColorSpace::Srgb),
        emissive: map(all, Content::Color, rate, ColorSpace::Srgb),
        normal: map(
            all,
            Content::Normal,
            Rate::usual(Content::Normal),
            ColorSpace::Linear,
        ),
        metallic_roughness: map(all, Content::Color, rate, ColorSpace::Linear),
        occlusion: map(all, Content::Gray, gray, ColorSpace::Linear),
        mask: map(
            scene == Scene::Masked,
            Content::Gray,
            gray,
            ColorSpace::Linear,
        ),
        filter,
        ..default()
    };
    let mut materials = world.resource_mut::<Assets<WaveletStandardMaterial>>();
    materials.add(WaveletStandardMaterial { base, extension })
}

fn wavelet_texture(
    world: &mut World,
    content: Content,
    rate: Rate,
    color_space: ColorSpace,
) -> Handle<WaveletTexture> {
    debug_assert_eq!(rate.content(false), content);
    let pixels = vec![[128; 3]; (TEXTURE_SIZE * TEXTURE_SIZE) as usize];
    let settings = EncodeSettings {
        rate,
        color_space,
        ..default()
    };
    let image = encode_rgb8(&pixels, [TEXTURE_SIZE; 2], &settings).expect("a valid image");
    world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(&image, WaveletStorage::Blocks, &mut textures, &mut images)
    })
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

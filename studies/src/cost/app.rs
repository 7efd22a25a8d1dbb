//! A configuration in an app: one quad with one material, one point light with shadows, one camera. So
//! each pass has one pipeline, and the pipelines of two configurations differ by the plugin only. Where fetches are
//! counted, a floor fills the picture, seen from near and far.

use bevy::{
    asset::RenderAssetUsages,
    camera::Hdr,
    core_pipeline::{
        prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
        tonemapping::{DebandDither, Tonemapping},
    },
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    light::{IrradianceVolume, SpotLightTexture},
    material::OpaqueRendererMethod,
    mesh::VertexAttributeValues,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_ewa::EwaPlugin;
use bevy_frugal_lab::{
    content::{self, add_texture, bricks, encoded, photo_like, wavelets},
    headless::{HeadlessApp, HeadlessSettings, LabTarget, TargetFormat},
};
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage, WaveletTexPlugin,
    WaveletTexture,
    codec::{
        image::{ColorSpace, Content},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use crate::cost::{
    CostError,
    configurations::{Configuration, Kind, Scene},
};

/// The app of a configuration, before its first frame.
pub fn app(configuration: &Configuration, scene: Scene) -> Result<HeadlessApp, CostError> {
    let kind = &configuration.kind;
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(64, 64), |app| {
        add_plugin(app, kind);
    })?;
    let world = app.world_mut();
    spawn_camera(world, kind, scene);
    spawn_light(world, Vec3::new(1.0, 1.0, 2.0));
    if scene == Scene::TexturedLight {
        let image = world.add_asset(texture(SMALL_TEXTURE, TextureFormat::Rgba8UnormSrgb));
        world.spawn((SpotLight::default(), SpotLightTexture { image }));
    }
    let mesh = Mesh::from(Rectangle::default()).with_generated_tangents();
    let mesh = mesh.map_err(|error| CostError::Failed(error.to_string()))?;
    let mesh = Mesh3d(world.add_asset(mesh));
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
    world.add_asset(image)
}

/// Side of the textures in pixels where it matters only that there are some: it is in no shader.
pub const SMALL_TEXTURE: u32 = 16;

/// Smallest side of wavelet textures in pixels: what an encoder finds in pictures decides which code decodes them.
const SMALLEST_WAVELET: u32 = 64;

/// A material of either type.
#[derive(Clone, Debug)]
pub enum Skin {
    Standard(Handle<StandardMaterial>),
    Wavelet(Handle<WaveletStandardMaterial>),
}

impl Skin {
    /// A material with textures of `size` pixels squared.
    pub fn new(world: &mut World, kind: &Kind, scene: Scene, size: u32) -> Self {
        if let Kind::Wavelet(filter, rate) = *kind {
            return Self::Wavelet(wavelet_material(world, scene, filter, rate, size));
        }
        let material = material(world, scene, Some(size));
        Self::Standard(world.add_asset::<StandardMaterial>(material))
    }

    pub fn put_on(&self, mut mesh: EntityWorldMut) {
        match self {
            Self::Standard(material) => mesh.insert(MeshMaterial3d(material.clone())),
            Self::Wavelet(material) => mesh.insert(MeshMaterial3d(material.clone())),
        };
    }
}

/// A material with textures where they have a size, and with the factors that they need.
fn material(world: &mut World, scene: Scene, size: Option<u32>) -> StandardMaterial {
    let mut images = world.resource_mut::<Assets<Image>>();
    let mut map = |is_used: bool, format| {
        let size = size.filter(|_| is_used)?;
        Some(images.add(texture(size, format)))
    };
    let (color, data) = (TextureFormat::Rgba8UnormSrgb, TextureFormat::Rgba8Unorm);
    let all = scene.has_five_maps();
    StandardMaterial {
        base_color_texture: map(true, color),
        emissive_texture: map(all, color),
        normal_map_texture: map(all || scene == Scene::NormalMapped, data),
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

/// A white texture with all its mip levels.
pub(super) fn texture(size: u32, format: TextureFormat) -> Image {
    let levels = size.ilog2() + 1;
    let texels: u32 = (0..levels).map(|level| (size >> level).max(1).pow(2)).sum();
    let mut image = content::texture([size; 2], format, levels, vec![255; 4 * texels as usize]);
    let mut sampler = ImageSamplerDescriptor::linear();
    sampler.set_address_mode(ImageAddressMode::Repeat);
    image.sampler = ImageSampler::Descriptor(sampler);
    image
}

fn wavelet_material(
    world: &mut World,
    scene: Scene,
    filter: WaveletFilter,
    rate: Option<Rate>,
    size: u32,
) -> Handle<WaveletStandardMaterial> {
    let base = material(world, scene, None);
    let mut map = |is_used: bool, content, rate, color_space| {
        is_used.then(|| wavelet_texture(world, size, content, rate, color_space))
    };
    let all = scene.has_five_maps();
    let gray = Rate::usual(Content::Gray);
    let color = rate.unwrap_or(Rate::Color3);
    let extension = WaveletExtension {
        base_color: map(rate.is_some(), Content::Color, color, ColorSpace::Srgb),
        emissive: map(all, Content::Color, color, ColorSpace::Srgb),
        normal: map(
            all,
            Content::Normal,
            Rate::usual(Content::Normal),
            ColorSpace::Linear,
        ),
        metallic_roughness: map(all, Content::Color, color, ColorSpace::Linear),
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
    size: u32,
    content: Content,
    rate: Rate,
    color_space: ColorSpace,
) -> Handle<WaveletTexture> {
    debug_assert_eq!(rate.content(false), content);
    let size = size.max(SMALLEST_WAVELET);
    let picture = match content {
        Content::Normal => bricks(size, size, 3).normal,
        _ => photo_like(size, size, 7),
    };
    let settings = EncodeSettings {
        // At 8 bits per pixel the encoder would choose BC7 for most textures; the row is about BC7.
        formats: if rate == Rate::Color8 {
            Formats::Plain
        } else {
            Formats::Wavelet
        },
        ..wavelets(rate, color_space)
    };
    let image = encoded(&picture, &settings).expect("a valid image");
    add_texture(world, &image, WaveletStorage::Blocks)
}

/// Size of the picture in pixels.
const FLOOR_SIZE: [u32; 2] = [160, 90];
/// Side of the textures in pixels.
const TEXTURE: u32 = 256;
/// Edge of the floor in metres, and how many textures there are along it.
const FLOOR: f32 = 120.0;
const TEXTURES: f32 = 80.0;
/// Height of the camera in metres.
const HEIGHT: f32 = 1.6;
/// The camera looks down by this angle in degrees. Half its vertical field of view is 22.5 degrees, so the floor is
/// seen under 4.5 to 49.5 degrees.
const PITCH: f32 = 27.0;

/// The app, before its first frame. Its picture is what the pixels return.
pub fn floor_app(kind: &Kind, scene: Scene) -> Result<HeadlessApp, CostError> {
    let settings =
        HeadlessSettings::with_size(FLOOR_SIZE[0], FLOOR_SIZE[1]).in_format(TargetFormat::Float32);
    let mut app = HeadlessApp::new(settings, |app| add_plugin(app, kind))?;
    let world = app.world_mut();
    spawn_camera(world, kind, scene);
    let place = Transform::from_xyz(0.0, HEIGHT, 0.0)
        .with_rotation(Quat::from_rotation_x(-PITCH.to_radians()));
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let cameras: Vec<_> = cameras.iter(world).collect();
    for camera in cameras {
        let as_it_is = (Tonemapping::None, DebandDither::Disabled);
        world.entity_mut(camera).insert((place, as_it_is));
    }
    spawn_light(world, Vec3::new(0.0, 3.0, -4.0));
    spawn_volume(world, kind);
    let mesh = Mesh3d(world.add_asset(floor()?));
    let skin = Skin::new(world, kind, scene, TEXTURE);
    skin.put_on(world.spawn(mesh));
    Ok(app)
}

fn floor() -> Result<Mesh, CostError> {
    let plane = Plane3d::default().mesh().size(FLOOR, FLOOR).build();
    let mut mesh = plane
        .with_generated_tangents()
        .map_err(|error| CostError::Failed(error.to_string()))?;
    if let Some(VertexAttributeValues::Float32x2(uvs)) = mesh.attribute_mut(Mesh::ATTRIBUTE_UV_0) {
        for uv in uvs {
            *uv = uv.map(|coordinate| coordinate * TEXTURES);
        }
    }
    Ok(mesh)
}

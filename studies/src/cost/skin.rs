//! The materials of the scenes: of Bevy, or of wavelet textures.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    material::OpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStandardMaterial, WaveletStorage, WaveletTexture,
    codec::{
        encoder::encode_rgb8,
        image::{ColorSpace, Content},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};

use super::{configurations::Kind, scene::Scene};
use bevy_frugal_lab::content::{bricks, photo_like};

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
        Self::Standard(
            world
                .resource_mut::<Assets<StandardMaterial>>()
                .add(material),
        )
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
    let mut map = |wanted: bool, format| {
        let size = size.filter(|_| wanted)?;
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
    let extent = Extent3d {
        width: size,
        height: size,
        depth_or_array_layers: 1,
    };
    let usages = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_uninit(extent, TextureDimension::D2, format, usages);
    let levels = extent.max_mips(wgpu::TextureDimension::D2);
    let texels: u32 = (0..levels).map(|level| (size >> level).max(1).pow(2)).sum();
    image.data = Some(vec![255; 4 * texels as usize]);
    image.texture_descriptor.mip_level_count = levels;
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
    let mut map = |wanted: bool, content, rate, color_space| {
        wanted.then(|| wavelet_texture(world, size, content, rate, color_space))
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
    let pixels: Vec<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
    let settings = EncodeSettings {
        rate,
        color_space,
        // At 8 bits per pixel the encoder would choose BC7 for most textures; the row is about BC7.
        formats: if rate == Rate::Color8 {
            Formats::Plain
        } else {
            Formats::Wavelet
        },
        ..default()
    };
    let image = encode_rgb8(&pixels, [size; 2], &settings).expect("a valid image");
    world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(&image, WaveletStorage::Blocks, &mut textures, &mut images)
    })
}

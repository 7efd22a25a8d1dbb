//! Procedural test content: materials and a photograph, made from a seed.
//!
//! Examples, tests and benches need images with the detail of real ones, but a repository should
//! not carry binary assets of several licences. So every image is computed: a pure function of
//! size and seed, the same bytes for the same arguments, at any size from 1x1 upwards (none at all
//! for a side of 0). A different seed gives another image of the same kind.
//!
//! | function | material | tiles | what it tests |
//! | --- | --- | --- | --- |
//! | [`bricks()`] | brick wall | yes | regular edges, fine grain, strong relief |
//! | [`wood()`] | plank floor | yes | directional detail |
//! | [`foliage()`] | leaves with gaps | yes | opacity, saturated greens, sharp veins |
//! | [`noise()`] | fractal rock | yes | detail of all scales at once |
//! | [`text()`] | printed page | no | thin strokes, hard edges |
//! | [`gradients()`] | smooth ramps | no | banding, dark tones, saturated hues |
//! | [`decals()`] | painted signs | yes | saturated edges of equal luma, thin coloured lines, flat colour |
//! | [`packed_maps()`] | occlusion, roughness, metallic | yes | uncorrelated channels |
//! | [`photo_like()`] | landscape | no | the statistics of a photograph |
//!
//! Surfaces are described as functions of a point (colour, height and coverage) in units of the
//! image's short side, sampled four times a pixel; normals are the central differences of the
//! heights. Sizes of details are thus relative to the image, and its resolution only sharpens it.
//!
//! [`mipped_texture`] makes a texture of an image, [`label`] one of a line of text; [`encoded`] and [`add_texture`] make
//! wavelet textures of pictures.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_wavelet_tex::{
    WaveletStorage, WaveletTexture,
    codec::{
        color::{linear_from_srgb, srgb_from_linear},
        encoder::{EncodeError, encode_rgb8},
        image::{ColorSpace, WaveletImage},
        plane::Plane,
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};
use image::{ImageBuffer, Pixel, RgbaImage};

pub use crate::content::{
    page::{gradients, label, text},
    photo::photo_like,
    surface::{Border, Material, Sample, assemble},
    tiles::{bricks, decals, foliage, noise, packed_maps, wood},
};

mod page;
mod photo;
mod surface;
mod tiles;

/// `pixels` as an RGBA8 texture that repeats, with a full chain of mips.
///
/// Mips of colours (`srgb`) are filtered in linear light.
pub fn mipped_texture(pixels: &RgbaImage, srgb: bool) -> Image {
    let (width, height) = pixels.dimensions();
    let curve = |channel: usize, f: fn(f32) -> f32, v: f32| {
        if srgb && channel < 3 { f(v) } else { v }
    };
    let mut planes = [0, 1, 2, 3].map(|channel| Plane {
        size: [width, height],
        values: pixels
            .pixels()
            .map(|p| curve(channel, linear_from_srgb, f32::from(p[channel]) / 255.0))
            .collect(),
    });
    let mut data = pixels.as_raw().clone();
    let mut levels = 1;
    while planes[0].size != [1, 1] {
        planes = planes.map(|plane| plane.next_mip());
        for i in 0..planes[0].values.len() {
            let texel = [0, 1, 2, 3].map(|channel: usize| {
                let encoded = curve(channel, srgb_from_linear, planes[channel].values[i]);
                (encoded * 255.0).round() as u8
            });
            data.extend(texel);
        }
        levels += 1;
    }
    let format = if srgb {
        TextureFormat::Rgba8UnormSrgb
    } else {
        TextureFormat::Rgba8Unorm
    };
    let mut image = texture([width, height], format, levels, data);
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

/// A texture with so many levels, of which the CPU keeps no copy.
pub fn texture(
    [width, height]: [u32; 2],
    format: TextureFormat,
    levels: u32,
    data: Vec<u8>,
) -> Image {
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let usages = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, usages);
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image
}

/// Settings that encode by a wavelet, even where a plain texture has less error.
pub fn wavelets(rate: Rate, color_space: ColorSpace) -> EncodeSettings {
    EncodeSettings {
        rate,
        color_space,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    }
}

/// Encodes the colours of a picture.
pub fn encoded<P: Pixel<Subpixel = u8>>(
    picture: &ImageBuffer<P, Vec<u8>>,
    settings: &EncodeSettings,
) -> Result<WaveletImage, EncodeError> {
    let pixels: Vec<[u8; 3]> = picture.pixels().map(|pixel| pixel.to_rgb().0).collect();
    encode_rgb8(&pixels, picture.dimensions().into(), settings)
}

/// Adds a wavelet texture to a world.
pub fn add_texture(
    world: &mut World,
    image: &WaveletImage,
    storage: WaveletStorage,
) -> Handle<WaveletTexture> {
    world.resource_scope(|world, mut textures: Mut<Assets<WaveletTexture>>| {
        let mut images = world.resource_mut::<Assets<Image>>();
        WaveletTexture::add(image, storage, &mut textures, &mut images)
    })
}

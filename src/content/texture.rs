//! An image as a texture of Bevy, with mips.

use bevy::{
    asset::RenderAssetUsages,
    image::{Image, ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_wavelet_tex::codec::{
    color::{linear_from_srgb, srgb_from_linear},
    plane::Plane,
};
use image::RgbaImage;

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
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let usage = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, usage);
    image.data = Some(data);
    image.texture_descriptor.mip_level_count = levels;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

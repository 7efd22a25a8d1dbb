//! Textures of light.

use bevy::{
    asset::RenderAssetUsages,
    image::ImageSampler,
    math::UVec3,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use half::f16;

/// A texture of 16-bit floats that is interpolated, from texels in rows of X, then Y, then Z.
pub fn texture(dimension: TextureDimension, size: UVec3, texels: &[Vec3]) -> Image {
    let halves = texels
        .iter()
        .flat_map(|light| light.extend(1.0).to_array().map(f16::from_f32));
    let mut image = Image::new(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: size.z,
        },
        dimension,
        halves.flat_map(f16::to_le_bytes).collect(),
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    // It clamps to the edges.
    image.sampler = ImageSampler::linear();
    image
}

//! Encoding of the levels of a plain texture.

use rayon::prelude::*;

use super::{color_blocks, texture::PlainTexture};
use crate::codec::{
    blocks::{self, BlockFormat, BlockQuality},
    color::ycocg_from_rgb,
    image::Content,
    interpolation::fitted,
    layout,
    plane::Plane,
    planes::unit,
    settings::Effort,
};

/// Weight of the differences between neighbouring texels when a smaller texture is fitted. Less lets
/// texels oscillate where a smaller texture is nearly as large as the image, more blurs.
const SMOOTHNESS: f32 = 0.01;

/// The channels of a content as textures hold them, each in `[0, 1]`.
pub(super) fn channels(
    content: Content,
    size: [u32; 2],
    pixel: impl Fn(usize) -> [f32; 4] + Sync,
) -> Vec<Plane> {
    let plane = |value: &(dyn Fn([f32; 4]) -> f32 + Sync)| Plane {
        size,
        values: (0..size[0] as usize * size[1] as usize)
            .into_par_iter()
            .map(|i| value(pixel(i)))
            .collect(),
    };
    let channel = |c: usize| plane(&move |p| p[c]);
    let normal = |c: usize| plane(&move |p| 0.5 + 0.5 * unit(p)[c]);
    match content {
        Content::Gray => vec![plane(&|[r, g, b, _]| ycocg_from_rgb([r, g, b]).y)],
        Content::Color => (0..3).map(channel).collect(),
        Content::ColorAlpha => (0..4).map(channel).collect(),
        Content::Normal => (0..2).map(normal).collect(),
    }
}

/// The texels of a level of `size` whose interpolation comes closest to the channels: these themselves where
/// it is not scaled, which are repeated beyond their edges.
pub(super) fn texels(channels: &[Plane], size: [u32; 2], is_scaled: bool) -> Vec<Plane> {
    let pixels = channels[0].size;
    if pixels == size {
        return channels.to_vec();
    }
    if !is_scaled {
        let padded = |channel: &Plane| Plane::from_fn(size, |x, y| channel.clamped(x, y));
        return channels.iter().map(padded).collect();
    }
    let axes = PlainTexture::axes(pixels, size, is_scaled);
    let fit = |channel: &Plane| {
        let mut texels = fitted(channel, axes, SMOOTHNESS);
        texels
            .values
            .iter_mut()
            .for_each(|v| *v = v.clamp(0.0, 1.0));
        texels
    };
    channels.par_iter().map(fit).collect()
}

/// The blocks of texels, a plane for each channel.
pub(super) fn blocks(format: BlockFormat, texels: &[Plane], effort: Effort) -> Vec<u8> {
    let size = texels[0].size;
    let quality = match effort {
        Effort::Fast => BlockQuality::Normal,
        Effort::Default | Effort::Best => BlockQuality::High,
    };
    let single = |c: usize| blocks::encode_bc4(&texels[c].values, size, quality);
    match format {
        BlockFormat::Bc1 => color_blocks::bc1(texels, effort),
        BlockFormat::Bc3 => unreachable!("no content has plain textures in BC3"),
        BlockFormat::Bc4 => single(0),
        BlockFormat::Bc5 => {
            let second = single(1);
            let (second, _) = second.as_chunks::<8>();
            blocks::with_alpha_blocks(&single(0), second)
        }
        BlockFormat::Bc7 => blocks::encode_bc7_rgba(size, [1; 4], |x, y| {
            std::array::from_fn(|c| texels.get(c).map_or(1.0, |plane| plane.clamped(x, y)))
        }),
    }
}

/// Appends the next level of an image of `image_size`, whose pixels `pixel` returns.
pub(in crate::codec) fn add_level(
    plain: &mut PlainTexture,
    level: u32,
    image_size: [u32; 2],
    pixel: impl Fn(usize) -> [f32; 4] + Sync,
    content: Content,
    effort: Effort,
) {
    let channels = channels(content, layout::mip_size(image_size, level), pixel);
    let is_scaled = plain.is_scaled(image_size);
    let texels = texels(&channels, plain.level_size(level), is_scaled);
    plain.blocks.extend(blocks(plain.format, &texels, effort));
}

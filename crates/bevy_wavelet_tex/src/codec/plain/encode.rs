//! Encoding of the levels of a plain texture.

use rayon::prelude::*;

use super::{color_blocks, texture::PlainTexture};
use crate::codec::{
    blocks::{self, BlockFormat, BlockQuality},
    color::ycocg_from_rgb,
    image::Content,
    interpolation::fitted,
    plane::Plane,
    planes::unit,
    settings::Effort,
    source::Pixels,
};

/// Weight of the differences between neighbouring texels when a smaller texture is fitted. Less lets
/// texels oscillate where a smaller texture is nearly as large as the image, more blurs.
const SMOOTHNESS: f32 = 0.01;

/// The channels of a level as textures hold them, each in `[0, 1]`.
#[derive(Clone, Copy)]
pub(in crate::codec) struct Channels<'a> {
    pub(super) size: [u32; 2],
    pixels: Pixels<'a>,
    content: Content,
}

impl<'a> Channels<'a> {
    pub(in crate::codec) fn new(pixels: Pixels<'a>, size: [u32; 2], content: Content) -> Self {
        Self {
            size,
            pixels,
            content,
        }
    }

    /// Number of channels.
    pub(super) fn count(&self) -> usize {
        match self.content {
            Content::Gray => 1,
            Content::Normal => 2,
            Content::Color => 3,
            Content::ColorAlpha => 4,
        }
    }

    /// All channels of a pixel; those beyond their number have no meaning.
    pub(super) fn pixel(&self, i: usize) -> [f32; 4] {
        let pixel = self.pixels.get(i);
        match self.content {
            Content::Gray => [ycocg_from_rgb([pixel[0], pixel[1], pixel[2]]).y; 4],
            Content::Color | Content::ColorAlpha => pixel,
            Content::Normal => {
                let [x, y, z] = unit(pixel).map(|v| 0.5 + 0.5 * v);
                [x, y, z, 1.0]
            }
        }
    }
}

/// The texels of a level of `size` whose interpolation comes closest to the channels: these themselves where
/// it is not scaled, which are repeated beyond their edges.
pub(super) fn texels(channels: &Channels<'_>, size: [u32; 2], is_scaled: bool) -> Vec<Plane> {
    let [width, height] = channels.size;
    let of_channel = |c: usize| {
        if !is_scaled || channels.size == size {
            return Plane::from_fn(size, |x, y| {
                let (x, y) = (x.min(width - 1), y.min(height - 1));
                channels.pixel(y as usize * width as usize + x as usize)[c]
            });
        }
        let axes = PlainTexture::axes(channels.size, size, is_scaled);
        let mut texels = fitted(axes, SMOOTHNESS, |i| channels.pixel(i)[c]);
        let values = texels.values.par_iter_mut();
        values.for_each(|v| *v = v.clamp(0.0, 1.0));
        texels
    };
    (0..channels.count()).map(of_channel).collect()
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

/// Appends the next level of an image of `image_size`.
pub(in crate::codec) fn add_level(
    plain: &mut PlainTexture,
    level: u32,
    image_size: [u32; 2],
    channels: &Channels<'_>,
    effort: Effort,
) {
    let is_scaled = plain.is_scaled(image_size);
    let texels = texels(channels, plain.level_size(level), is_scaled);
    plain.blocks.extend(blocks(plain.format, &texels, effort));
}

//! Encoding of the levels of a plain texture.

use std::ops::Range;

use rayon::prelude::*;

use super::{color_blocks, texture::PlainTexture};
use crate::codec::{
    blocks::{self, BlockFormat, BlockQuality, ColorEncoder, Starts},
    color::ycocg_from_rgb,
    image::Content,
    interpolation::{NormalEquations, Tap, fitted_by},
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
    pub(super) pixels: Pixels<'a>,
    pub(super) content: Content,
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

    /// The value of a channel of a pixel.
    fn value(&self, i: usize, c: usize) -> f32 {
        match self.content {
            Content::Color | Content::ColorAlpha => self.pixels.channel(i, c),
            Content::Gray => {
                let [r, g, b, _] = self.pixels.get(i);
                ycocg_from_rgb([r, g, b]).y
            }
            Content::Normal => 0.5 + 0.5 * unit(self.pixels.get(i))[c],
        }
    }
}

/// The texels of a level of `size` whose interpolation comes closest to the channels.
fn texels(channels: &Channels<'_>, size: [u32; 2], is_scaled: bool) -> Vec<Plane> {
    let taps = PlainTexture::axes(channels.size, size, is_scaled).map(|axis| axis.all_taps());
    fitted_texels(channels, &taps, &size.map(|s| 0..s), is_scaled)
}

/// The texels of a part of a level whose interpolation comes closest to the channels between them: these themselves where
/// the level is not scaled, which are repeated beyond their edges. `taps` are those of all pixels of a row, and of a
/// column.
pub(super) fn fitted_texels(
    channels: &Channels<'_>,
    taps: &[Vec<Tap>; 2],
    part: &[Range<u32>; 2],
    is_scaled: bool,
) -> Vec<Plane> {
    let [width, height] = channels.size;
    let [left, top] = part.each_ref().map(|range| range.start);
    let size = part.each_ref().map(|range| range.end - range.start);
    if !is_scaled {
        let of_channel = |c: usize| {
            Plane::from_fn(size, |x, y| {
                let (x, y) = ((left + x).min(width - 1), (top + y).min(height - 1));
                channels.value(y as usize * width as usize + x as usize, c)
            })
        };
        return (0..channels.count()).map(of_channel).collect();
    }
    // The pixels that lie between these texels.
    let inside = [0, 1].map(|axis: usize| {
        let (taps, part) = (&taps[axis], &part[axis]);
        taps.partition_point(|tap| tap.0 < part.start)..taps.partition_point(|tap| tap.1 < part.end)
    });
    let columns = inside[0].len();
    let first = inside[1].start * width as usize + inside[0].start;
    let of_channel = |c: usize| {
        let taps = [0, 1].map(|axis: usize| {
            let start = part[axis].start;
            let taps = taps[axis][inside[axis].clone()].iter();
            taps.map(|(a, b, u)| (a - start, b - start, *u)).collect()
        });
        let mut texels = fitted_by(taps, size, SMOOTHNESS, |i| {
            channels.value(first + i / columns * width as usize + i % columns, c)
        });
        let values = texels.values.par_iter_mut();
        values.for_each(|v| *v = v.clamp(0.0, 1.0));
        texels
    };
    (0..channels.count()).map(of_channel).collect()
}

/// The blocks of texels, a plane for each channel. Those beyond `visible` are padding.
pub(super) fn blocks(
    format: BlockFormat,
    texels: &[Plane],
    visible: [u32; 2],
    effort: Effort,
) -> Vec<u8> {
    let size = texels[0].size;
    let quality = match effort {
        Effort::Fast => BlockQuality::Normal,
        Effort::Default | Effort::Best => BlockQuality::High,
    };
    let single = |c: usize| blocks::encode_bc4(&texels[c].values, size, quality);
    match format {
        BlockFormat::Bc1 => color_blocks::bc1(texels, visible, effort),
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
    let size = plain.level_size(level);
    let texels = texels(channels, size, is_scaled);
    let visible = if is_scaled { size } else { channels.size };
    let mut blocks = blocks(plain.format, &texels, visible, effort);
    if is_scaled && plain.format == BlockFormat::Bc1 && effort != Effort::Fast {
        let axes = PlainTexture::axes(channels.size, size, is_scaled);
        let equations = NormalEquations::new(axes, |c, i| channels.value(i, c));
        let (blocks, _) = blocks.as_chunks_mut();
        ColorEncoder::new(Starts::One).refine(blocks, equations, size);
    }
    plain.blocks.extend(blocks);
}

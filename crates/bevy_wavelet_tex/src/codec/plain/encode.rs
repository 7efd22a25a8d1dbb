//! Encoding of the levels of a plain texture.

use std::ops::Range;

use rayon::prelude::*;

use super::PlainTexture;
use crate::codec::{
    blocks::{
        BlockFormat, BlockQuality, ColorEncoder, Starts, decode_blocks, encode_bc1, encode_bc4,
        encode_bc7_rgba, is_dark, map_blocks, with_alpha_blocks,
    },
    color::ycocg_from_rgb,
    image::Content,
    interpolation::{NormalEquations, Tap, fitted_by},
    plane::Plane,
    settings::Effort,
    source::{Pixels, unit},
};

/// Weight of the differences between neighbouring texels when a smaller texture is fitted. Less lets
/// texels oscillate where a smaller texture is nearly as large as the image, more blurs.
const SMOOTHNESS: f32 = 0.01;

/// The channels of a level as textures hold them, each in `[0, 1]`.
#[derive(Clone, Copy)]
pub(in crate::codec) struct Channels<'a> {
    pub(in crate::codec) size: [u32; 2],
    pub(in crate::codec) pixels: Pixels<'a>,
    pub(in crate::codec) content: Content,
}

impl Channels<'_> {
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
    let single = |c: usize| encode_bc4(&texels[c].values, size, effort.block_quality());
    match format {
        BlockFormat::Bc1 => color_blocks(texels, visible, effort),
        BlockFormat::Bc3 => unreachable!("no content has plain textures in BC3"),
        BlockFormat::Bc4 => single(0),
        BlockFormat::Bc5 => {
            let second = single(1);
            let (second, _) = second.as_chunks::<8>();
            with_alpha_blocks(&single(0), second)
        }
        BlockFormat::Bc7 => encode_bc7_rgba(size, [1; 4], |x, y| {
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
    let axes = PlainTexture::axes(channels.size, size, is_scaled);
    let taps = axes.map(|axis| axis.all_taps());
    let texels = fitted_texels(channels, &taps, &size.map(|s| 0..s), is_scaled);
    let visible = if is_scaled { size } else { channels.size };
    let mut blocks = blocks(plain.format, &texels, visible, effort);
    if is_scaled && plain.format == BlockFormat::Bc1 && effort != Effort::Fast {
        let equations = NormalEquations::new(axes, |c, i| channels.value(i, c));
        let (blocks, _) = blocks.as_chunks_mut();
        ColorEncoder::new(Starts::One).refine(blocks, equations, size);
    }
    plain.blocks.extend(blocks);
}

type Block = [[f32; 3]; 16];

/// BC1 blocks of texels, a plane for each channel, in the mode of each that has the least error. The texels beyond
/// `visible` are those of padding.
fn color_blocks(texels: &[Plane], visible: [u32; 2], effort: Effort) -> Vec<u8> {
    let blocks = blocks_of(texels);
    let encoder = ColorEncoder::new(effort.starts());
    let columns = texels[0].size[0].div_ceil(4) as usize;
    let encoded = |(i, colors): (usize, &Block)| {
        let on_line = encoder.block(colors);
        if effort == Effort::Fast {
            return on_line.0;
        }
        if effort == Effort::Default && !colors.iter().any(is_dark) {
            return on_line.0;
        }
        let with_black = encoder.block_with_black(colors, on_line.1);
        if effort == Effort::Default {
            let is_better = with_black.1 < on_line.1;
            return if is_better { with_black.0 } else { on_line.0 };
        }
        let left = [i % columns, i / columns].map(|block| 4 * block as u32);
        let visible = [0, 1].map(|axis: usize| visible[axis].saturating_sub(left[axis]));
        let error = |block: &[u8; 8]| error(block, colors, visible);
        let found = [on_line.0, with_black.0, by_library(colors)];
        let least = found
            .into_iter()
            .min_by(|a, b| error(a).total_cmp(&error(b)));
        least.expect("there are three")
    };
    let blocks: Vec<[u8; 8]> = blocks.par_iter().enumerate().map(encoded).collect();
    blocks.into_flattened()
}

/// The block of another encoder.
fn by_library(colors: &Block) -> [u8; 8] {
    let texels = colors.map(|[r, g, b]| [r, g, b, 1.0].map(|v| (v * 255.0 + 0.5) as u8));
    let block = encode_bc1(&texels, [4, 4], BlockQuality::High);
    *block.first_chunk().expect("a block")
}

/// The squared error of the visible texels of a block.
fn error(block: &[u8; 8], expected: &Block, [columns, rows]: [u32; 2]) -> f32 {
    let texels = decode_blocks(BlockFormat::Bc1, block, [4, 4]);
    let of = |i: usize| -> f32 {
        (0..3)
            .map(|c| (texels[i][c] - expected[i][c]).powi(2))
            .sum()
    };
    let is_visible = |i: &usize| ((*i % 4) as u32) < columns && ((*i / 4) as u32) < rows;
    (0..16).filter(is_visible).map(of).sum()
}

/// 4 x 4 colours for each block. Beyond the edges the outermost texels are repeated.
fn blocks_of(texels: &[Plane]) -> Vec<Block> {
    let color = |(x, y)| [0, 1, 2].map(|c: usize| texels[c].clamped(x, y));
    map_blocks(texels[0].size, |at| at.map(color))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_effort_has_less_error() {
        let channel = |c: u32| {
            Plane::from_fn([80, 64], |x, y| {
                let hash = (x * 73 + y * 179 + c * 283) % 97;
                let smooth = (x * (c + 3) + y) as f32 / 200.0;
                if hash < 20 { 0.0 } else { smooth.min(1.0) }
            })
        };
        let texels = [channel(0), channel(1), channel(2)];
        let total = |effort| {
            let blocks = color_blocks(&texels, [80, 64], effort);
            let (blocks, _) = blocks.as_chunks::<8>();
            let colors = blocks_of(&texels);
            let errors = blocks.iter().zip(&colors);
            errors
                .map(|(block, expected)| error(block, expected, [4, 4]))
                .sum::<f32>()
        };
        let errors = [Effort::Fast, Effort::Default, Effort::Best].map(total);
        println!("{errors:?}");
        assert!(errors[1] < errors[0] && errors[2] < errors[1]);
    }
}

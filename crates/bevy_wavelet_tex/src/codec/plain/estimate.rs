//! The error of a plain texture that is not encoded yet, from a part of its pixels.

use std::ops::Range;

use rayon::prelude::*;

use super::{
    encode::{Channels, blocks, fitted_texels},
    texture::{PlainTexture, mix},
};
use crate::codec::{
    blocks::{BlockFormat, decode_blocks},
    interpolation::Tap,
    plane::Plane,
    quality::pixel_error,
    settings::Effort,
    windows::Window,
};

/// Texels around a window whose pixels decide with its own which texels fit best: each has a third of the influence of
/// the one before.
const MARGIN: u32 = 6;

/// The texels between which the pixels of a window lie, in whole blocks.
struct Part<'a> {
    window: &'a Window,
    /// The first texel.
    corner: [u32; 2],
    /// A plane for each channel.
    texels: Vec<Plane>,
}

/// A level of a texture that is not encoded yet.
pub(super) struct LevelEstimate<'a> {
    format: BlockFormat,
    /// The channels of the image.
    channels: &'a Channels<'a>,
    /// The two texels between which each pixel of a row, and of a column, lies.
    taps: [Vec<Tap>; 2],
    parts: Vec<Part<'a>>,
}

impl<'a> LevelEstimate<'a> {
    /// Fits the texels of the windows of a level to the channels of an image.
    pub(super) fn new(
        channels: &'a Channels<'a>,
        format: BlockFormat,
        size: [u32; 2],
        is_scaled: bool,
        windows: &'a [Window],
    ) -> Self {
        let taps = PlainTexture::axes(channels.size, size, is_scaled).map(|axis| axis.all_taps());
        let part = |window: &'a Window| {
            let range = |axis: usize| {
                let taps =
                    &taps[axis][window.corner[axis] as usize..][..window.size[axis] as usize];
                let (first, last) = (taps[0].0, taps[taps.len() - 1].1);
                first / 4 * 4..(last + 1).next_multiple_of(4).min(size[axis])
            };
            let inner = [range(0), range(1)];
            let outer = [0, 1].map(|axis: usize| match is_scaled {
                true => {
                    let Range { start, end } = inner[axis];
                    start.saturating_sub(MARGIN)..(end + MARGIN).min(size[axis])
                }
                false => inner[axis].clone(),
            });
            let fitted = fitted_texels(channels, &taps, &outer, is_scaled);
            let [columns, rows] = inner.each_ref().map(|range| range.end - range.start);
            let [left, top] = [0, 1].map(|axis: usize| inner[axis].start - outer[axis].start);
            let cut = |plane: Plane| {
                let at = |x, y| plane.clamped(left + x, top + y);
                Plane::from_fn([columns, rows], at)
            };
            Part {
                window,
                corner: inner.map(|range| range.start),
                texels: fitted.into_iter().map(cut).collect(),
            }
        };
        let parts = windows.par_iter().map(part).collect();
        Self {
            format,
            channels,
            taps,
            parts,
        }
    }

    /// Mean squared error of the pixels in 8-bit units, where the texels are read without being encoded.
    pub(super) fn error_of_size(&self) -> f64 {
        self.mean_error(|part| {
            let texels = 0..part.texels[0].values.len();
            texels.map(|i| texel(&part.texels, i)).collect()
        })
    }

    /// The same with encoded texels.
    pub(super) fn error(&self, effort: Effort) -> f64 {
        self.mean_error(|part| {
            let size = part.texels[0].size;
            let blocks = blocks(self.format, &part.texels, size, effort);
            decode_blocks(self.format, &blocks, size)
        })
    }

    fn mean_error(&self, read: impl Fn(&Part<'_>) -> Vec<[f32; 4]> + Sync) -> f64 {
        let of_part = |part: &Part<'_>| self.sum_of_errors(part, &read(part));
        let sums: Vec<u64> = self.parts.par_iter().map(of_part).collect();
        let pixels: usize = self.parts.iter().map(|part| part.window.pixels()).sum();
        sums.iter().sum::<u64>() as f64 / (pixels * self.channels.content.error_channels()) as f64
    }

    fn sum_of_errors(&self, part: &Part<'_>, texels: &[[f32; 4]]) -> u64 {
        let [left, top] = part.window.corner;
        let [columns, rows] = part.window.size;
        let width = part.texels[0].size[0] as usize;
        let content = self.channels.content;
        let row = |y: u32| -> u64 {
            let (above, below, v) = self.taps[1][y as usize];
            let line = |y: u32| texels[(y - part.corner[1]) as usize * width..][..width].iter();
            let pairs = line(above).zip(line(below));
            let blended: Vec<[f32; 4]> = pairs.map(|(a, b)| mix(*a, *b, v)).collect();
            let start = y as usize * self.channels.size[0] as usize;
            let pixel = |x: u32| {
                let (first, second, u) = self.taps[0][x as usize];
                let [a, b] = [first, second].map(|x| blended[(x - part.corner[0]) as usize]);
                let expected = self.channels.pixels.get(start + x as usize);
                let read = content.of_channels(mix(a, b, u));
                u64::from(pixel_error(content, expected, read))
            };
            (left..left + columns).map(pixel).sum()
        };
        (top..top + rows).map(row).sum()
    }
}

/// All channels of a texel. Those that are missing are 1.
fn texel(planes: &[Plane], i: usize) -> [f32; 4] {
    std::array::from_fn(|c| planes.get(c).map_or(1.0, |plane| plane.values[i]))
}

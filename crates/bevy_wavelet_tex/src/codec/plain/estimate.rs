//! A plain texture that is not encoded yet, and its error from a part of its blocks.

use std::ops::Range;

use rayon::prelude::*;

use super::{
    encode::{Channels, blocks, texels},
    read::mix,
    texture::PlainTexture,
};
use crate::codec::{
    blocks::{BlockFormat, decode_blocks},
    interpolation::Tap,
    plane::Plane,
    settings::Effort,
};

/// One block of so many is encoded, or all where there are fewer than [`LEAST_BLOCKS`].
const EVERY: u32 = 6;
/// Blocks of a texture of 192 x 192 texels.
pub(super) const LEAST_BLOCKS: u32 = 2304;

/// A level of a texture that is not encoded yet.
pub(super) struct LevelTexels<'a> {
    format: BlockFormat,
    size: [u32; 2],
    is_scaled: bool,
    /// A plane for each channel.
    texels: Vec<Plane>,
    /// The channels of the image.
    channels: &'a Channels<'a>,
    /// The two texels between which each pixel of a row, and of a column, lies.
    taps: [Vec<Tap>; 2],
}

impl<'a> LevelTexels<'a> {
    /// Fits the texels of a level to the channels of an image.
    pub(super) fn new(
        channels: &'a Channels<'a>,
        format: BlockFormat,
        size: [u32; 2],
        is_scaled: bool,
    ) -> Self {
        Self {
            format,
            size,
            is_scaled,
            texels: texels(channels, size, is_scaled),
            channels,
            taps: PlainTexture::axes(channels.size, size, is_scaled).map(|axis| axis.all_taps()),
        }
    }

    /// Mean squared error of the channels where the texels are read without being encoded.
    pub(super) fn error_of_size(&self) -> f64 {
        if !self.is_scaled {
            return 0.0;
        }
        let (sum, count) = self.error([0, 0], self.size, |i| texel(&self.texels, i));
        sum / count as f64
    }

    /// Mean squared error of the channels with encoded texels: that of the size, of all texels, and what
    /// encoding adds to it in a part of them.
    pub(super) fn estimated_error(&self, error_of_size: f64) -> f64 {
        let (corners, [width, height]) = self.windows();
        // The windows are encoded together, one below the other.
        let size = [width, height * corners.len() as u32];
        let part = |plane: &Plane| {
            Plane::from_fn(size, |x, y| {
                let [left, top] = corners[(y / height) as usize];
                plane.clamped(left + x, top + y % height)
            })
        };
        let parts: Vec<Plane> = self.texels.iter().map(part).collect();
        let blocks = blocks(self.format, &parts, Effort::Default);
        let mean_error = |texel: &(dyn Fn(usize) -> [f32; 4] + Sync)| {
            let windows = corners.par_iter().enumerate();
            let errors: Vec<(f64, usize)> = windows
                .map(|(window, corner)| {
                    let first = window * (width * height) as usize;
                    self.error(*corner, [width, height], |i| texel(first + i))
                })
                .collect();
            let (sums, counts): (Vec<f64>, Vec<usize>) = errors.into_iter().unzip();
            sums.iter().sum::<f64>() / counts.iter().sum::<usize>() as f64
        };
        let decoded = decode_blocks(self.format, &blocks, size);
        let added = mean_error(&|i| decoded[i]);
        error_of_size + added - mean_error(&|i| texel(&parts, i))
    }

    /// The first texels of the windows that are encoded, and the size of all of them: a part of each row
    /// of blocks, another one in each row, or the whole of a small texture.
    fn windows(&self) -> (Vec<[u32; 2]>, [u32; 2]) {
        let [columns, rows] = self.size.map(|s| s / 4);
        if columns < 2 * EVERY || columns * rows < LEAST_BLOCKS {
            return (vec![[0, 0]], self.size);
        }
        // 5 has no divisor in common with the number of parts, so the rows go through all of them.
        let part = |row: u32| row * 5 % EVERY * columns / EVERY;
        let corners = (0..rows).map(|row| [4 * part(row), 4 * row]).collect();
        (corners, [columns / EVERY * 4, 4])
    }

    /// Sum of the squared errors, and their number, over the pixels between the texels of a window.
    fn error(
        &self,
        corner: [u32; 2],
        size: [u32; 2],
        texel: impl Fn(usize) -> [f32; 4] + Sync,
    ) -> (f64, usize) {
        let inside = |axis: usize| -> Range<usize> {
            let taps = &self.taps[axis];
            let end = corner[axis] + size[axis];
            taps.partition_point(|tap| tap.0 < corner[axis])
                ..taps.partition_point(|tap| tap.1 < end)
        };
        let [columns, rows] = [inside(0), inside(1)];
        let count = columns.len() * rows.len() * self.channels.count();
        let row = |y: usize| {
            let (above, below, v) = self.taps[1][y];
            let line = |y: u32| {
                let first = ((y - corner[1]) * size[0]) as usize;
                (first..first + size[0] as usize).map(&texel)
            };
            let pairs = line(above).zip(line(below));
            let blended: Vec<[f32; 4]> = pairs.map(|(a, b)| mix(a, b, v)).collect();
            let start = y * self.channels.size[0] as usize;
            let pixel = |x: usize| {
                let (left, right, u) = self.taps[0][x];
                let [a, b] = [left, right].map(|x| blended[(x - corner[0]) as usize]);
                let (read, wanted) = (mix(a, b, u), self.channels.pixel(start + x));
                let error = |c: usize| (wanted[c] - read[c]).powi(2);
                f64::from((0..self.channels.count()).map(error).sum::<f32>())
            };
            columns.clone().map(pixel).sum::<f64>()
        };
        let sums: Vec<f64> = rows.into_par_iter().map(row).collect();
        (sums.into_iter().sum(), count)
    }
}

/// All channels of a texel. Those that are missing are 1.
fn texel(planes: &[Plane], i: usize) -> [f32; 4] {
    std::array::from_fn(|c| planes.get(c).map_or(1.0, |plane| plane.values[i]))
}

//! A plain texture that is not encoded yet, and its error from a part of its blocks.

use rayon::prelude::*;

use super::{
    encode::{blocks, texels},
    read::Rows,
    texture::PlainTexture,
};
use crate::codec::{
    blocks::{BlockFormat, decode_blocks},
    interpolation::Axis,
    plane::Plane,
    settings::Effort,
};

/// Rows of texels of a strip: two rows of blocks, so that pixels between them count too.
const STRIP: u32 = 8;
/// One strip of so many is encoded.
const EVERY: u32 = 6;
/// Textures of images with fewer strips are encoded as a whole.
const LEAST_STRIPS: u32 = 4;

/// The first level of a texture that is not encoded yet.
pub(super) struct Candidate {
    format: BlockFormat,
    size: [u32; 2],
    /// A plane for each channel.
    texels: Vec<Plane>,
}

impl Candidate {
    /// Fits the texels of a texture to the channels of an image.
    pub(super) fn new(channels: &[Plane], format: BlockFormat, size: [u32; 2]) -> Self {
        let texels = texels(channels, size);
        Self {
            format,
            size,
            texels,
        }
    }

    pub(super) fn encoded(&self, effort: Effort) -> PlainTexture {
        PlainTexture {
            format: self.format,
            size: self.size,
            blocks: blocks(self.format, &self.texels, effort),
        }
    }

    /// Mean squared error of the channels where the texels are read without being encoded.
    pub(super) fn error_of_size(&self, channels: &[Plane]) -> f64 {
        if self.size == channels[0].size {
            return 0.0;
        }
        let (sum, count) = error(channels, interleaved(&self.texels), 0, self.size);
        sum / count as f64
    }

    /// Mean squared error of the channels with encoded texels: that of the size, of all texels, and what
    /// encoding adds to it in strips, or in all texels of small textures.
    pub(super) fn estimated_error(&self, channels: &[Plane], error_of_size: f64) -> f64 {
        let row = self.size[0] as usize;
        let (firsts, rows) = self.strips(channels[0].size[1]);
        // The strips are encoded together, one below the other.
        let size = [self.size[0], rows * firsts.len() as u32];
        let part = |plane: &Plane| {
            let strip = |first: &u32| &plane.values[*first as usize * row..][..rows as usize * row];
            let values = firsts.iter().map(strip).collect::<Vec<_>>().concat();
            Plane { size, values }
        };
        let parts: Vec<Plane> = self.texels.iter().map(part).collect();
        let blocks = blocks(self.format, &parts, Effort::Default);
        let mean_error = |texels: Vec<[f32; 4]>| {
            let strips = texels.chunks_exact(rows as usize * row).zip(&firsts);
            let (sums, counts): (Vec<f64>, Vec<usize>) = strips
                .map(|(texels, first)| error(channels, texels.to_vec(), *first, self.size))
                .unzip();
            sums.iter().sum::<f64>() / counts.iter().sum::<usize>() as f64
        };
        let added = mean_error(decode_blocks(self.format, &blocks, size));
        error_of_size + added - mean_error(interleaved(&parts))
    }

    /// The first rows of the strips that are encoded, and the number of their rows. They are at the same
    /// positions of an image of `height` rows for all sizes of textures.
    fn strips(&self, height: u32) -> (Vec<u32>, u32) {
        let count = height / (STRIP * EVERY);
        if count < LEAST_STRIPS || self.size[1] < 2 * STRIP {
            return (vec![0], self.size[1]);
        }
        let first =
            |i: u32| ((2 * i + 1) * self.size[1] / (2 * count)).saturating_sub(STRIP / 2) / 4 * 4;
        let last = self.size[1] - STRIP;
        ((0..count).map(|i| first(i).min(last)).collect(), STRIP)
    }
}

/// Texels of all channels. Those that are missing are 1.
fn interleaved(planes: &[Plane]) -> Vec<[f32; 4]> {
    let channel = |i: usize, c: usize| planes.get(c).map_or(1.0, |plane| plane.values[i]);
    (0..planes[0].values.len())
        .into_par_iter()
        .map(|i| std::array::from_fn(|c| channel(i, c)))
        .collect()
}

/// Sum of the squared errors, and their number, over the rows of pixels that `texels` have all of.
fn error(channels: &[Plane], texels: Vec<[f32; 4]>, first: u32, texture: [u32; 2]) -> (f64, usize) {
    let size = channels[0].size;
    let axes = [0, 1].map(|i: usize| Axis::stretched(size[i], texture[i]));
    let rows = Rows::new(texels, first, axes);
    let of_row = |y: u32| {
        let width = size[0] as usize;
        let start = y as usize * width;
        let pixel = |(x, read): (usize, [f32; 4])| {
            let pairs = channels.iter().zip(read);
            pairs
                .map(|(plane, read)| (plane.values[start + x] - read).powi(2))
                .sum::<f32>()
        };
        rows.row(y)
            .enumerate()
            .map(pixel)
            .map(f64::from)
            .sum::<f64>()
    };
    let sums: Vec<f64> = (0..size[1])
        .into_par_iter()
        .filter(|y| rows.have(*y))
        .map(of_row)
        .collect();
    let values = sums.len() * size[0] as usize * channels.len();
    (sums.into_iter().sum(), values)
}

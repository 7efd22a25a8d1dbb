//! The error of a plain texture from a part of its blocks.

use rayon::prelude::*;

use super::{encode::blocks, read::Rows};
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
/// Textures of fewer rows are encoded as a whole.
const LEAST_ROWS: u32 = 4 * STRIP * EVERY;

/// Mean squared error of the channels where `texels` are read without being encoded.
pub(super) fn error_of_size(channels: &[Plane], texels: &[Plane]) -> f64 {
    let size = texels[0].size;
    let texel = |i: usize| std::array::from_fn(|c| texels.get(c).map_or(1.0, |p| p.values[i]));
    let all = (0..size[0] as usize * size[1] as usize)
        .into_par_iter()
        .map(texel)
        .collect();
    let (sum, count) = error(channels, all, 0, size);
    sum / count as f64
}

/// Mean squared error of the channels with encoded texels, estimated from strips. `None` where the
/// texture is too small for strips.
pub(super) fn error_of_strips(
    channels: &[Plane],
    texels: &[Plane],
    format: BlockFormat,
) -> Option<f64> {
    let [width, height] = texels[0].size;
    if height < LEAST_ROWS {
        return None;
    }
    let strips = height / (STRIP * EVERY);
    let strip = |strip: u32| {
        let first = (strip * EVERY + EVERY / 2) * STRIP;
        let rows = (first * width) as usize..((first + STRIP) * width) as usize;
        let size = [width, STRIP];
        let part = |plane: &Plane| Plane {
            size,
            values: plane.values[rows.clone()].to_vec(),
        };
        let parts: Vec<Plane> = texels.iter().map(part).collect();
        let blocks = blocks(format, &parts, Effort::Default);
        let texels = decode_blocks(format, &blocks, size);
        error(channels, texels, first, [width, height])
    };
    let errors: Vec<(f64, usize)> = (0..strips).map(strip).collect();
    let sum: f64 = errors.iter().map(|(sum, _)| sum).sum();
    let count: usize = errors.iter().map(|(_, count)| count).sum();
    Some(sum / count as f64)
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

//! The error of a wavelet image against its source.

use rayon::prelude::*;

use super::{
    blocks::decode_blocks,
    color::ycocg_from_rgb,
    decoder::LevelRows,
    image::{Content, WaveletImage},
    source::Source,
};

/// PSNR of the largest level in dB, with both images rounded to 8 bits: over R, G and B (and alpha
/// where it is kept), over luma for gray, over X, Y and Z for normals. It is infinite where the
/// images are identical.
pub fn psnr_db(source: &Source<'_>, image: &WaveletImage) -> f64 {
    psnr_of(mse(source, image))
}

/// Mean squared error of the same, in 8-bit units squared.
pub fn mse(source: &Source<'_>, image: &WaveletImage) -> f64 {
    level_mse(source, image, 0)[0]
}

/// How much a mip level is used, against the largest one: each half as much as the one before.
///
/// A surface shows each level over about as many pixels of the screen as the others, but the smaller ones where it is
/// far away, and seldom those of a few pixels.
pub(super) fn level_weight(level: usize) -> f64 {
    0.5f64.powi(level as i32)
}

/// The mean of the errors of all levels, by how much they are used.
pub(super) fn chain_mse(source: &Source<'_>, image: &WaveletImage) -> f64 {
    mse_with_luma(source, image).0
}

/// The same, and the part of it that is that of luma: how large the error of colour would be if chroma
/// had none.
pub(super) fn mse_with_luma(source: &Source<'_>, image: &WaveletImage) -> (f64, f64) {
    let (mut sums, mut weights) = ([0.0; 2], 0.0);
    for level in 0..image.levels {
        let weight = level_weight(level as usize);
        let errors = level_mse(source, image, level);
        sums = [0, 1].map(|i| sums[i] + weight * errors[i]);
        weights += weight;
    }
    let [all, luma] = sums.map(|sum| sum / weights);
    (all, luma)
}

/// The mean squared error of all channels of a level with both images rounded to 8 bits, and that of luma.
fn level_mse(source: &Source<'_>, image: &WaveletImage, level: u32) -> [f64; 2] {
    let rows = LevelRows::new(image, level, decode_blocks);
    let pixels = &source.levels[level as usize];
    let content = image.content;
    let channels = match content {
        Content::Gray => 1,
        Content::Color | Content::Normal => 3,
        Content::ColorAlpha => 4,
    };
    let axis = image.axes.weights()[0];
    let luma = |pixel: [f32; 4]| (0..3).map(|c| 255.0 * axis[c] * pixel[c]).sum::<f32>();
    // `f32::round` would be a call of a library.
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    let [width, height] = rows.size;
    let of_row = |row: &mut Vec<[f32; 4]>, y: u32| {
        rows.fill(y, row);
        let mut sums = [0.0; 2];
        for (x, decoded) in row.iter().enumerate() {
            let mut wanted = pixels.get(y as usize * width as usize + x);
            if content == Content::Gray {
                wanted[0] = ycocg_from_rgb([wanted[0], wanted[1], wanted[2]]).y;
            }
            let of_channel = |c: usize| {
                let decoded = match content {
                    Content::Normal => 0.5 + 0.5 * decoded[c],
                    _ => decoded[c],
                };
                let difference = i32::from(byte(wanted[c])) - i32::from(byte(decoded));
                difference * difference
            };
            sums[0] += f64::from((0..channels).map(of_channel).sum::<i32>());
            sums[1] += f64::from(luma(wanted) - luma(*decoded)).powi(2);
        }
        sums
    };
    // Row by row, so that the sum does not depend on the number of threads.
    let row = || vec![[0.0; 4]; width as usize];
    let sums: Vec<[f64; 2]> = (0..height).into_par_iter().map_init(row, of_row).collect();
    let count = f64::from(width) * f64::from(height);
    let sum = |i: usize| sums.iter().map(|sums| sums[i]).sum::<f64>() / count;
    [sum(0) / channels as f64, sum(1)]
}

/// Converts a mean squared error, in 8-bit units squared, to a PSNR in dB.
pub fn psnr_of(mse: f64) -> f64 {
    10.0 * (255.0 * 255.0 / mse).log10()
}

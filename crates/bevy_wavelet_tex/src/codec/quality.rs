//! The error of a wavelet image against its source.

use rayon::prelude::*;

use super::{
    color::ycocg_from_rgb,
    decoder::{DecodedImage, decode},
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
    mse_of(source, image, &decode(image, 0))
}

/// The same, and the part of it that is that of luma: how large the error of colour would be if chroma
/// had none.
pub(super) fn mse_with_luma(source: &Source<'_>, image: &WaveletImage) -> (f64, f64) {
    let decoded = decode(image, 0);
    let [r, g, b] = image.axes.weights()[0];
    let luma = |pixel: [f32; 3]| 255.0 * (r * pixel[0] + g * pixel[1] + b * pixel[2]);
    let of_pixel = |i: usize| {
        let [r, g, b, _] = source.levels[0].get(i);
        f64::from(luma([r, g, b]) - luma(decoded.pixels[i])).powi(2)
    };
    let luma_mse = sum(decoded.pixels.len(), of_pixel) / decoded.pixels.len() as f64;
    (mse_of(source, image, &decoded), luma_mse)
}

fn mse_of(source: &Source<'_>, image: &WaveletImage, decoded: &DecodedImage) -> f64 {
    let decoded = decoded.to_rgba8(image.content);
    let pixels = &source.levels[0];
    let channels = match image.content {
        Content::Gray => 1,
        Content::Color | Content::Normal => 3,
        Content::ColorAlpha => 4,
    };
    let of_pixel = |i: usize| {
        let mut wanted = pixels.get(i);
        if image.content == Content::Gray {
            wanted[0] = ycocg_from_rgb([wanted[0], wanted[1], wanted[2]]).y;
        }
        let of_channel = |c: usize| {
            let wanted = (wanted[c] * 255.0 + 0.5) as u8;
            f64::from(wanted.abs_diff(decoded[i][c])).powi(2)
        };
        (0..channels).map(of_channel).sum::<f64>()
    };
    sum(decoded.len(), of_pixel) / (channels * decoded.len()) as f64
}

/// A sum over pixels, in chunks of a fixed size so that it does not depend on the number of threads.
fn sum(count: usize, of_pixel: impl Fn(usize) -> f64 + Sync) -> f64 {
    let chunks = (0..count).into_par_iter().chunks(4096);
    let sums: Vec<f64> = chunks
        .map(|indices| indices.into_iter().map(&of_pixel).sum::<f64>())
        .collect();
    sums.into_iter().sum()
}

/// Converts a mean squared error, in 8-bit units squared, to a PSNR in dB.
pub fn psnr_of(mse: f64) -> f64 {
    10.0 * (255.0 * 255.0 / mse).log10()
}

/// Sum of squared differences.
pub(super) fn squared_error(a: &[f32], b: &[f32]) -> f64 {
    // The chunks have a fixed size so that the sum does not depend on the number of threads.
    a.par_chunks(4096)
        .zip(b.par_chunks(4096))
        .map(|(a, b)| {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>()
        })
        .collect::<Vec<_>>()
        .into_iter()
        .sum()
}

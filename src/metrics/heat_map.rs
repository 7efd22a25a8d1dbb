//! Errors as images to look at, in the "magma" colours that FLIP's authors use: black is no
//! error, then purple, red and a pale yellow for the largest.

use image::{Rgb, RgbImage};

use crate::metrics::{SizeMismatch, check_sizes, flip::FlipMap};

/// Paints a FLIP map: black is 0, pale yellow 1. No gain, so that maps compare with one another
/// and with those in the literature.
pub fn flip_heat_map(map: &FlipMap) -> RgbImage {
    RgbImage::from_fn(map.width, map.height, |x, y| {
        magma(map.values[y as usize * map.width as usize + x as usize])
    })
}

/// Paints the largest absolute channel difference of every pixel, times `gain`: pale yellow is a
/// difference of `255 / gain` or more. State the gain beside the picture; 8 to 16 suit compression.
pub fn absolute_error_heat_map(
    reference: &RgbImage,
    test: &RgbImage,
    gain: f32,
) -> Result<RgbImage, SizeMismatch> {
    check_sizes(reference, test)?;
    Ok(RgbImage::from_fn(
        reference.width(),
        reference.height(),
        |x, y| {
            let (a, b) = (reference.get_pixel(x, y).0, test.get_pixel(x, y).0);
            let difference = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
            magma(f32::from(difference) / 255.0 * gain)
        },
    ))
}

/// The "magma" map of matplotlib (N. Smith and S. van der Walt, 2015, CC0) at 0 to 1, in sRGB, as
/// the sixth-degree fit by M. Zucker (CC0), within 5 of 255 levels of the table.
pub fn magma(value: f32) -> Rgb<u8> {
    const COEFFICIENTS: [[f32; 3]; 7] = [
        [-0.002_136_485, -0.000_749_655, -0.005_386_128],
        [0.251_660_54, 0.677_523_24, 2.494_026_6],
        [8.353_717, -3.577_719_5, 0.314_467_9],
        [-27.668_733, 14.264_731, -13.649_213],
        [52.176_14, -27.943_606, 12.944_169],
        [-50.768_525, 29.046_583, 4.234_153],
        [18.655_705, -11.489_774, -5.601_961_5],
    ];
    let t = value.clamp(0.0, 1.0);
    Rgb([0, 1, 2].map(|c| {
        let channel = COEFFICIENTS
            .iter()
            .rev()
            .fold(0.0, |sum, row| sum * t + row[c]);
        (channel * 255.0).round() as u8 // Saturates.
    }))
}

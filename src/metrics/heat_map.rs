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

#[cfg(test)]
mod tests {
    use super::*;

    fn luma([r, g, b]: [u8; 3]) -> f32 {
        0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b)
    }

    #[test]
    fn magma_rises_in_brightness_from_black_to_pale_yellow() {
        let lumas: Vec<f32> = (0..=64).map(|i| luma(magma(i as f32 / 64.0).0)).collect();
        assert!(lumas.windows(2).all(|pair| pair[1] > pair[0]), "{lumas:?}");
        assert!(lumas[0] < 2.0 && lumas[64] > 240.0, "{lumas:?}");
        assert_eq!((magma(-1.0), magma(2.0)), (magma(0.0), magma(1.0)));
    }

    #[test]
    fn gain_saturates_at_its_stated_difference() {
        let reference = RgbImage::from_pixel(2, 1, Rgb([100; 3]));
        let mut test = reference.clone();
        test.put_pixel(1, 0, Rgb([100, 68, 101]));
        let map = absolute_error_heat_map(&reference, &test, 4.0).unwrap();
        assert_eq!(*map.get_pixel(0, 0), magma(0.0));
        assert_eq!(*map.get_pixel(1, 0), magma(32.0 / 255.0 * 4.0));
        let map = absolute_error_heat_map(&reference, &test, 8.0).unwrap();
        assert_eq!(*map.get_pixel(1, 0), magma(1.0));
        assert!(absolute_error_heat_map(&reference, &RgbImage::new(1, 1), 1.0).is_err());
    }

    #[test]
    fn a_flip_map_keeps_its_layout() {
        let map = FlipMap {
            width: 2,
            height: 2,
            values: vec![0.0, 0.25, 0.5, 1.0],
        };
        let image = flip_heat_map(&map);
        assert_eq!(*image.get_pixel(1, 0), magma(0.25));
        assert_eq!(*image.get_pixel(0, 1), magma(0.5));
    }
}

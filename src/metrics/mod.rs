//! How far a test image is from its reference.
//!
//! Four figures, because none suffices alone. MSE and PSNR are what the compression literature
//! reports; the maximum error exposes a single broken block that an average hides; FLIP predicts
//! what a viewer notices when flipping between the two images, so it forgives noise too fine to
//! see and punishes a lost edge. All are exact functions of the pixels: the same on every machine
//! up to the rounding of `powf`, and independent of the number of threads.
//!
//! | item | gives |
//! | --- | --- |
//! | [`mse`], [`psnr_db`], [`max_error`] | mean squared error, PSNR and maximum error of pixels, in 8-bit units |
//! | [`flip`] | the FLIP error of every pixel and its mean |
//! | [`heat_map`] | error maps as images to look at |

use image::RgbImage;

pub use crate::metrics::flip::DEFAULT_PIXELS_PER_DEGREE;

pub mod flip;
pub mod heat_map;

/// The figures that [`compare`] reports for a pair of images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageError {
    /// Mean squared error over all pixels and channels, in squared 8-bit units: 0 to 65025.
    pub mse: f64,
    /// Peak signal-to-noise ratio in dB, infinite for equal images (see [`psnr_db`]).
    pub psnr_db: f64,
    /// Largest absolute difference of any channel of any pixel, in 8-bit units: 0 to 255.
    pub max_error: u8,
    /// Mean FLIP error at [`DEFAULT_PIXELS_PER_DEGREE`]: 0 (equal) to 1.
    pub flip: f64,
}

/// Compares two sRGB images of the same size by every metric of this module.
///
/// Images without pixels count as equal.
pub fn compare(reference: &RgbImage, test: &RgbImage) -> Result<ImageError, SizeMismatch> {
    let mse = mse(reference, test)?;
    Ok(ImageError {
        mse,
        psnr_db: psnr_db(mse),
        max_error: max_error(reference, test)?,
        flip: flip::flip_map(reference, test, DEFAULT_PIXELS_PER_DEGREE)?.mean(),
    })
}

/// Two images cannot be compared pixel by pixel because their sizes differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "image sizes differ: the reference is {}x{} pixels, the test image {}x{}",
    reference.0, reference.1, test.0, test.1
)]
pub struct SizeMismatch {
    /// Width and height of the reference, in pixels.
    pub reference: (u32, u32),
    /// Width and height of the test image, in pixels.
    pub test: (u32, u32),
}

/// Mean squared error over all pixels and channels, in squared 8-bit units: 0 to 65025.
///
/// The sum is taken in integers, hence exact; images without pixels have an error of 0.
pub fn mse(reference: &RgbImage, test: &RgbImage) -> Result<f64, SizeMismatch> {
    let sum: u64 = differences(reference, test)?
        .map(|d| u64::from(d) * u64::from(d))
        .sum();
    let count = reference.as_raw().len().max(1);
    Ok(sum as f64 / count as f64)
}

/// Peak signal-to-noise ratio in dB, `10 log10(255² / mse)`, of a mean squared error in squared
/// 8-bit units.
///
/// Equal images (`mse` of 0) give [`f64::INFINITY`] rather than an `Option`: it is the limit of
/// the formula, it prints as `inf`, and thresholds such as `psnr_db > 40.0` need no special case.
pub fn psnr_db(mse: f64) -> f64 {
    10.0 * (255.0 * 255.0 / mse).log10()
}

/// Largest absolute difference of any channel of any pixel, in 8-bit units: 0 to 255.
pub fn max_error(reference: &RgbImage, test: &RgbImage) -> Result<u8, SizeMismatch> {
    Ok(differences(reference, test)?.max().unwrap_or(0))
}

/// Refuses images of different sizes.
fn check_sizes(reference: &RgbImage, test: &RgbImage) -> Result<(), SizeMismatch> {
    if reference.dimensions() == test.dimensions() {
        Ok(())
    } else {
        Err(SizeMismatch {
            reference: reference.dimensions(),
            test: test.dimensions(),
        })
    }
}

/// Absolute differences, channel by channel in raster order.
fn differences<'a>(
    reference: &'a RgbImage,
    test: &'a RgbImage,
) -> Result<impl Iterator<Item = u8> + 'a, SizeMismatch> {
    check_sizes(reference, test)?;
    Ok(reference
        .iter()
        .zip(test.iter())
        .map(|(a, b)| a.abs_diff(*b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn equal_images_have_no_error() {
        let image = RgbImage::from_fn(19, 7, |x, y| Rgb([(x * 13) as u8, (y * 31) as u8, 90]));
        let error = compare(&image, &image).unwrap();
        let expected = ImageError {
            mse: 0.0,
            psnr_db: f64::INFINITY,
            max_error: 0,
            flip: 0.0,
        };
        assert_eq!(error, expected);
    }

    #[test]
    fn degenerate_sizes_are_compared() {
        let none = RgbImage::new(0, 0);
        assert_eq!(compare(&none, &none).unwrap().flip, 0.0);

        let black = RgbImage::new(1, 1);
        let white = RgbImage::from_pixel(1, 1, Rgb([255; 3]));
        let error = compare(&black, &white).unwrap();
        assert_eq!(
            (error.mse, error.psnr_db, error.max_error),
            (65025.0, 0.0, 255)
        );
        assert!(error.flip > 0.9 && error.flip <= 1.0, "{error:?}");
    }

    #[test]
    fn a_size_mismatch_names_both_sizes() {
        let error = compare(&RgbImage::new(3, 2), &RgbImage::new(2, 3)).unwrap_err();
        assert_eq!(
            error,
            SizeMismatch {
                reference: (3, 2),
                test: (2, 3)
            }
        );
        let message = error.to_string();
        assert!(
            message.contains("3x2") && message.contains("2x3"),
            "{message}"
        );
    }

    #[test]
    fn a_constant_offset_of_one_is_48_13_db() {
        let reference = RgbImage::from_fn(17, 5, |x, y| Rgb([x as u8, y as u8, 254]));
        let test = RgbImage::from_fn(17, 5, |x, y| Rgb([x as u8 + 1, y as u8 + 1, 255]));
        let mse = mse(&reference, &test).unwrap();
        assert_eq!(mse, 1.0);
        assert!((psnr_db(mse) - 48.130_803_608_679).abs() < 1e-9);
        assert_eq!(max_error(&reference, &test), Ok(1));
    }

    #[test]
    fn one_channel_of_one_pixel_counts_once() {
        let reference = RgbImage::from_pixel(2, 2, Rgb([100; 3]));
        let mut test = reference.clone();
        test.put_pixel(1, 0, Rgb([100, 88, 100]));
        for (a, b) in [(&reference, &test), (&test, &reference)] {
            assert_eq!(mse(a, b), Ok(144.0 / 12.0));
            assert_eq!(max_error(a, b), Ok(12));
        }
    }

    #[test]
    fn extreme_errors_are_exact() {
        let (black, white) = (
            RgbImage::new(64, 64),
            RgbImage::from_pixel(64, 64, Rgb([255; 3])),
        );
        assert_eq!(mse(&black, &white), Ok(65025.0));
        assert_eq!(psnr_db(65025.0), 0.0);
        assert_eq!(psnr_db(0.0), f64::INFINITY);
    }
}

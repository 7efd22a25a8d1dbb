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

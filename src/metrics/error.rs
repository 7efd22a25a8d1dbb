//! Pixel-wise errors in 8-bit units: mean squared error, PSNR and maximum error.

use image::RgbImage;

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
pub(super) fn check_sizes(reference: &RgbImage, test: &RgbImage) -> Result<(), SizeMismatch> {
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

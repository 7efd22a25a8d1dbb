//! How far a test image is from its reference.
//!
//! Four figures, because none suffices alone. MSE and PSNR are what the compression literature
//! reports; the maximum error exposes a single broken block that an average hides; FLIP predicts
//! what a viewer notices when flipping between the two images, so it forgives noise too fine to
//! see and punishes a lost edge. All are exact functions of the pixels: the same on every machine
//! up to the rounding of `powf`, and independent of the number of threads.
//!
//! | module | gives |
//! | --- | --- |
//! | [`error`] | MSE, PSNR and maximum error, in 8-bit units |
//! | [`flip`] | the FLIP error of every pixel and its mean |
//! | [`heat_map`] | error maps as images to look at |

use image::RgbImage;

pub use crate::metrics::{error::SizeMismatch, flip::DEFAULT_PIXELS_PER_DEGREE};

pub mod error;
pub mod flip;
pub mod heat_map;

/// The figures that [`compare`] reports for a pair of images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageError {
    /// Mean squared error over all pixels and channels, in squared 8-bit units: 0 to 65025.
    pub mse: f64,
    /// Peak signal-to-noise ratio in dB, infinite for equal images (see [`error::psnr_db`]).
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
    let mse = error::mse(reference, test)?;
    Ok(ImageError {
        mse,
        psnr_db: error::psnr_db(mse),
        max_error: error::max_error(reference, test)?,
        flip: flip::flip_map(reference, test, DEFAULT_PIXELS_PER_DEGREE)?.mean(),
    })
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
}

//! The decoded image, which all decoders of image files return.

use bevy_wavelet_tex::codec::image::ColorSpace;
use image::DynamicImage;

/// A decoded image.
pub struct Decoded {
    pub image: DynamicImage,
    /// The color space that the file states in its format, which of these only KTX2 does.
    pub color_space: Option<ColorSpace>,
    /// Whether the image has red and green alone, so that its blue is zero.
    pub is_red_green: bool,
}

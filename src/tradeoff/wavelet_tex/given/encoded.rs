//! The texture of an image.

use bevy_wavelet_tex::codec::{
    encoder::{EncodeError, encode},
    image::WaveletImage,
    quality::psnr_db,
    settings::EncodeSettings,
    source::{Pixels, Source},
};
use image::DynamicImage;

/// Encodes an image with all its bits. Returns the PSNR in dB, too.
pub(super) fn encoded(
    image: &DynamicImage,
    settings: &EncodeSettings,
) -> Result<(WaveletImage, f64), EncodeError> {
    let words: Vec<_> = image.to_rgba16().pixels().map(|p| p.0).collect();
    let size = [image.width(), image.height()];
    let source = Source::new(size, Pixels::Rgba16(&words));
    let texture = encode(&source, settings, &|_, _| {})?;
    let psnr = psnr_db(&source, &texture);
    Ok((texture, psnr))
}

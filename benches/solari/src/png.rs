//! Pictures as files, to look at.

use std::path::Path;

use bevy::{color::Srgba, prelude::*};
use image::{ImageResult, Rgb, RgbImage};

/// Writes a picture in which this radiance is a middle gray.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, width: u32, picture: &[Vec3], gray: f32) -> ImageResult<()> {
    let height = picture.len() as u32 / width;
    let image = RgbImage::from_fn(width, height, |x, y| {
        let light = picture[(x + y * width) as usize] * 0.2 / gray;
        Rgb(
            Srgba::from(LinearRgba::from_vec3(light.clamp(Vec3::ZERO, Vec3::ONE)))
                .to_u8_array_no_alpha(),
        )
    });
    image.save(path)
}

/// The mean of all channels of a picture.
pub fn mean(picture: &[Vec3]) -> f32 {
    picture.iter().sum::<Vec3>().element_sum() / (3 * picture.len()).max(1) as f32
}

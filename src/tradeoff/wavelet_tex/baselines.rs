//! The BC formats, at full size and at lower resolutions, and two levels of wavelets.
//!
//! | setting | picture |
//! | --- | --- |
//! | `bc1`, `bc7`, `bc4` | the BC formats at full size; BC4 of gray |
//! | `bc1 at 3 bpp, bilinear`, `..bicubic` and so on | a texture of a lower resolution (thesis section 3.6.1): downsampled by Lanczos until it takes the bits of a wavelet rate, and upsampled again |
//! | `two levels` | two levels of wavelets, gray at 1.5 bpp (thesis section 3.5.4) |

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1, encode_bc4, encode_bc7},
    color::ycocg_from_rgb,
};
use image::{Rgb, Rgb32FImage, RgbImage, RgbaImage, buffer::ConvertBuffer, imageops};

use super::{encoded::ORIGINAL, two_levels::through_two_levels};
use crate::{
    metrics::{SizeMismatch, compare},
    record::Measurement,
};

/// The filters that sample textures of a lower resolution.
pub(super) const FILTERS: [(&str, imageops::FilterType); 2] = [
    ("bilinear", imageops::FilterType::Triangle),
    ("bicubic", imageops::FilterType::CatmullRom),
];

/// The bits per pixel of lower resolutions, which are those of the wavelet rates.
const GRAY_BITS: [f64; 3] = [1.5, 2.0, 3.0];
const COLOR_BITS: [(BlockFormat, f64); 4] = [
    (BlockFormat::Bc1, 2.25),
    (BlockFormat::Bc1, 3.0),
    (BlockFormat::Bc1, 3.25),
    (BlockFormat::Bc7, 5.0),
];

/// Name of the setting in which a format is at a lower resolution.
pub(super) fn scaled_name(format: BlockFormat, bpp: f64, filter: &str) -> String {
    format!("{} at {bpp} bpp, {filter}", format.name())
}

/// A picture that was encoded and decoded.
pub(super) struct Through {
    pub(super) decoded: Rgb32FImage,
    /// Bytes of the blocks.
    bytes: usize,
    encode_ms: f64,
}

/// Encodes and decodes a picture in BC1, BC7, or BC4, which has red in all channels.
pub(super) fn through(format: BlockFormat, picture: &Rgb32FImage) -> Through {
    let size = <[u32; 2]>::from(picture.dimensions());
    let (blocks, encode_ms) = match format {
        BlockFormat::Bc4 => {
            let values: Vec<f32> = picture.pixels().map(|p| p.0[0].clamp(0.0, 1.0)).collect();
            timed(|| encode_bc4(&values, size, BlockQuality::High))
        }
        BlockFormat::Bc7 => timed(|| encode_bc7(size, [1; 3], |x, y| picture.get_pixel(x, y).0)),
        _ => {
            let rgba: RgbaImage = picture.convert();
            let texels: Vec<_> = rgba.pixels().map(|p| p.0).collect();
            timed(|| encode_bc1(&texels, size, BlockQuality::High))
        }
    };
    let texels = decode_blocks(format, &blocks, size);
    let decoded = Rgb32FImage::from_fn(size[0], size[1], |x, y| {
        let [r, g, b, _] = texels[(y * size[0] + x) as usize];
        Rgb(match format {
            BlockFormat::Bc4 => [r; 3],
            _ => [r, g, b],
        })
    });
    Through {
        decoded,
        bytes: blocks.len(),
        encode_ms,
    }
}

/// The result of a function and the milliseconds that it took.
fn timed<T>(function: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = function();
    (result, start.elapsed().as_secs_f64() * 1e3)
}

/// BC1 of a colour image, which every study has.
pub(super) fn bc1_row(scene: &str, image: &RgbImage) -> Result<Measurement, SizeMismatch> {
    Picture::color(scene, image).at_full_size(BlockFormat::Bc1)
}

/// All other rows of a colour image and of its luma.
pub(super) fn rows(scene: &str, image: &RgbImage) -> Result<Vec<Measurement>, SizeMismatch> {
    let color = Picture::color(scene, image);
    let gray = Picture::luma(scene, image);
    let mut rows = vec![
        color.at_full_size(BlockFormat::Bc7)?,
        gray.at_full_size(BlockFormat::Bc4)?,
    ];
    for filter in FILTERS {
        for (format, bpp) in COLOR_BITS {
            rows.push(color.scaled(format, bpp, filter)?);
        }
        for bpp in GRAY_BITS {
            rows.push(gray.scaled(BlockFormat::Bc4, bpp, filter)?);
        }
    }
    rows.push(gray.row("two levels", |picture| {
        let (decoded, bytes, encode_ms) = through_two_levels(picture);
        Through {
            decoded,
            bytes,
            encode_ms,
        }
    })?);
    Ok(rows)
}

/// The image that rows are made of.
struct Picture {
    scene: String,
    pixels: Rgb32FImage,
}

impl Picture {
    fn color(scene: &str, image: &RgbImage) -> Self {
        Self::of(scene.into(), image, |rgb| rgb)
    }

    /// The luma of YCoCg, rounded to 8 bits, in all channels.
    fn luma(scene: &str, image: &RgbImage) -> Self {
        Self::of(format!("{scene} gray"), image, |rgb| {
            [(ycocg_from_rgb(rgb).y * 255.0).round() / 255.0; 3]
        })
    }

    fn of(scene: String, image: &RgbImage, value: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        let mut pixels: Rgb32FImage = image.convert();
        for pixel in pixels.pixels_mut() {
            pixel.0 = value(pixel.0);
        }
        Self { scene, pixels }
    }

    fn at_full_size(&self, format: BlockFormat) -> Result<Measurement, SizeMismatch> {
        self.row(format.name(), |picture| through(format, picture))
    }

    /// The format at a lower resolution, such that it takes `bpp`.
    fn scaled(
        &self,
        format: BlockFormat,
        bpp: f64,
        (name, filter): (&str, imageops::FilterType),
    ) -> Result<Measurement, SizeMismatch> {
        let bits_per_pixel = format.block_bytes() as f64 / 2.0;
        let scale = (bpp / bits_per_pixel).sqrt();
        let (width, height) = self.pixels.dimensions();
        let [w, h] = [width, height].map(|s| ((f64::from(s) * scale).round() as u32).max(1));
        self.row(&scaled_name(format, bpp, name), |picture| {
            let small = imageops::resize(picture, w, h, imageops::FilterType::Lanczos3);
            let small = through(format, &small);
            Through {
                decoded: imageops::resize(&small.decoded, width, height, filter),
                ..small
            }
        })
    }

    /// The row of a setting, which encodes and decodes the picture.
    fn row(
        &self,
        setting: &str,
        encode_and_decode: impl FnOnce(&Rgb32FImage) -> Through,
    ) -> Result<Measurement, SizeMismatch> {
        let through = encode_and_decode(&self.pixels);
        Ok(Measurement {
            scene: self.scene.clone(),
            setting: setting.into(),
            reference: ORIGINAL.into(),
            cpu_ms: Some(through.encode_ms),
            bytes: Some(through.bytes as u64),
            fetches: Some(1.0),
            ..Measurement::from(&compare(
                &self.pixels.convert(),
                &through.decoded.convert(),
            )?)
        })
    }
}

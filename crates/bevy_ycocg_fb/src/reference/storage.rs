//! Rounding of a packed pixel by its storage format.
//!
//! Floats round to nearest, ties to even, as render targets are known to do on GPUs (the
//! specifications allow either of the two neighbours); 8-bit values round to nearest.

use super::pack::PackedPixel;
use crate::settings::PackedFormat;

/// Rounds to the nearest 16-bit float.
pub fn round_f16(value: f32) -> f32 {
    half::f16::from_f32(value).to_f32()
}

/// Rounds to the nearest of 256 values from 0 to 1; values outside are clamped, and NaN becomes 0.
pub fn round_unorm8(value: f32) -> f32 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8 as f32 / 255.0
}

/// Returns the pixel as it is read from a target of this format after it was written.
pub fn stored(pixel: PackedPixel, format: PackedFormat) -> PackedPixel {
    let round = match format {
        PackedFormat::Float16 => round_f16,
        PackedFormat::Float32 => |value| value,
        PackedFormat::Unorm8 => round_unorm8,
    };
    PackedPixel {
        luminance: round(pixel.luminance),
        chrominance: round(pixel.chrominance),
    }
}

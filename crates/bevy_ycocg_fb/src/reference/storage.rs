//! What a format makes of a packed pixel.
//!
//! Floats round to nearest, ties to even, as the conversion of a render target does on the GPUs we
//! know of (the specifications allow any of the two neighbours); 8-bit values round to nearest.

use super::pack::PackedPixel;
use crate::settings::PackedFormat;

/// The largest finite 16-bit float.
pub const F16_MAX: f32 = 65504.0;

/// The nearest 16-bit float.
pub fn round_f16(value: f32) -> f32 {
    half::f16::from_f32(value).to_f32()
}

/// The nearest of 256 values from 0 to 1; what lies outside is clamped, NaN is 0.
pub fn round_unorm8(value: f32) -> f32 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8 as f32 / 255.0
}

/// What is read from a target of this format after the pixel has been written to it.
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

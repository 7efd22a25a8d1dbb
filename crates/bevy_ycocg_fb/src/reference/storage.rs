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

pub mod unorm8 {
    //! Packing for the 8-bit format, and its codes.
    //!
    //! Steps of equal size, as the thesis has them (4.7.2), are as large as those of an 8-bit display, and the rounding of
    //! luminance and of two chrominances adds up. Where errors are seen first, in the dark and near gray, these codes
    //! have steps of a third of that; steps of white and of the most saturated colours are three times as large.

    use crate::reference::{
        color::srgb_from_linear,
        pack::{PackedPixel, pack, sanitized},
    };

    /// Bias of the code of a chrominance. One half, as in the thesis (4.7.2), lies between two of the 256 values and would
    /// tint gray; this is one of the two.
    pub const BIAS: f32 = 128.0 / 255.0;

    /// Slope of the codes at 0; at 1 it is the inverse.
    pub const SLOPE: f32 = 3.0;

    /// Returns the code of a value of 0 to 1, in the same range.
    pub fn compressed(value: f32) -> f32 {
        SLOPE * value / (1.0 + (SLOPE - 1.0) * value)
    }

    /// Inverts [`compressed`].
    pub fn expanded(code: f32) -> f32 {
        code / (SLOPE - (SLOPE - 1.0) * code)
    }

    /// Returns the codes of a pixel with luminance of 0 to 1 and chrominance of -1/2 to 1/2.
    pub fn code(pixel: PackedPixel) -> PackedPixel {
        let saturation = compressed(2.0 * pixel.chrominance.abs());
        PackedPixel {
            luminance: compressed(pixel.luminance),
            chrominance: (0.5 * saturation).copysign(pixel.chrominance) + BIAS,
        }
    }

    /// Inverts [`code`]. Values outside the range of codes are clamped to it.
    pub fn decoded(code: PackedPixel) -> PackedPixel {
        let signed = code.chrominance - BIAS;
        let saturation = expanded((2.0 * signed.abs()).min(1.0));
        PackedPixel {
            luminance: expanded(code.luminance.clamp(0.0, 1.0)),
            chrominance: (0.5 * saturation).copysign(signed),
        }
    }

    /// Packs a display-linear colour of 0 to 1 for the 8-bit format.
    pub fn pack_unorm8(rgb: [f32; 3], x: u32, y: u32) -> PackedPixel {
        let encoded = sanitized(rgb).map(|channel| srgb_from_linear(channel.min(1.0)));
        code(pack(encoded, x, y))
    }
}

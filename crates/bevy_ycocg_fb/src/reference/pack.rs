//! Packing of a fragment's colour (thesis, listing 4.1): conversion of RGB to YCoCg and back (thesis, eq. 3.3), and
//! rounding of the packed pixel by its storage format; a packed viewport, with mirrored neighbours beyond its border.
//!
//! Floats round to nearest, ties to even, as render targets are known to do on GPUs (the
//! specifications allow either of the two neighbours); 8-bit values round to nearest.

use crate::settings::PackedFormat;

/// A colour as luminance and two chrominances, in the units of its RGB channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct YCoCg {
    /// Luminance, `R / 4 + G / 2 + B / 4`.
    pub y: f32,
    /// Orange chrominance, `(R - B) / 2`: from -2 Y to 2 Y.
    pub co: f32,
    /// Green chrominance, `G / 2 - (R + B) / 4`: from -Y to Y.
    pub cg: f32,
}

/// Converts RGB to YCoCg. No absolute value is larger than the largest channel, so that a colour that a
/// float format can store still fits after the conversion.
pub fn ycocg_from_rgb([r, g, b]: [f32; 3]) -> YCoCg {
    // The channels are scaled before they are added, as sums of large channels would overflow.
    YCoCg {
        y: 0.25 * r + 0.5 * g + 0.25 * b,
        co: 0.5 * r - 0.5 * b,
        cg: 0.5 * g - 0.25 * r - 0.25 * b,
    }
}

/// Converts YCoCg to RGB.
pub fn rgb_from_ycocg(YCoCg { y, co, cg }: YCoCg) -> [f32; 3] {
    [y + co - cg, y + cg, y - co - cg]
}

/// Encodes a display-linear value of 0 to 1 as sRGB.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Decodes an sRGB-encoded value of 0 to 1 to a display-linear one.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// The largest finite 16-bit float.
pub const F16_MAX: f32 = 65504.0;

/// A packed pixel: luminance and one chrominance, which is Co if `x + y` of the pixel's position in the
/// target is even, else Cg.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PackedPixel {
    /// Luminance; in the 8-bit format, the code of that of the sRGB-encoded channels.
    pub luminance: f32,
    /// Co or Cg; in the 8-bit format, the code of that of the sRGB-encoded channels.
    pub chrominance: f32,
}

/// Returns true if the pixel at this position of its target stores Co, and false if it stores Cg.
pub fn stores_co(x: u32, y: u32) -> bool {
    (x ^ y) & 1 == 0
}

/// Sanitizes the colour that a material computed: NaN becomes 0, and other values are clamped to 0 to
/// 65504.
///
/// A single pixel with NaN or infinity would otherwise spread through filters, bloom and temporal
/// accumulation.
pub fn sanitized(rgb: [f32; 3]) -> [f32; 3] {
    rgb.map(|channel| {
        if channel.is_nan() {
            0.0
        } else {
            channel.clamp(0.0, F16_MAX)
        }
    })
}

/// Packs a scene-linear colour for the float formats.
pub fn pack(rgb: [f32; 3], x: u32, y: u32) -> PackedPixel {
    let color = ycocg_from_rgb(sanitized(rgb));
    PackedPixel {
        luminance: color.y,
        chrominance: if stores_co(x, y) { color.co } else { color.cg },
    }
}

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

/// A viewport of packed pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedImage {
    /// Position of the first pixel in the target, in pixels, which determines the parity.
    pub offset: [u32; 2],
    /// Width and height in pixels, both at least 1.
    pub size: [u32; 2],
    /// Storage format of the pixels.
    pub format: PackedFormat,
    /// The pixels in row-major order from the top left.
    pub pixels: Vec<PackedPixel>,
}

impl PackedImage {
    /// Packs colours as a viewport at `offset` stores them. The colours are scene-linear for the float
    /// formats and display-linear for the 8-bit format.
    pub fn pack(
        colors: &[[f32; 3]],
        size: [u32; 2],
        offset: [u32; 2],
        format: PackedFormat,
    ) -> Self {
        let pack = match format {
            PackedFormat::Float16 | PackedFormat::Float32 => pack,
            PackedFormat::Unorm8 => unorm8::pack_unorm8,
        };
        let pixels = colors.iter().enumerate().map(|(i, color)| {
            let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
            stored(pack(*color, offset[0] + x, offset[1] + y), format)
        });
        Self {
            offset,
            size,
            format,
            pixels: pixels.collect(),
        }
    }

    /// Returns true if this pixel of the viewport stores Co, and false if it stores Cg.
    pub fn stores_co(&self, x: u32, y: u32) -> bool {
        stores_co(self.offset[0] + x, self.offset[1] + y)
    }

    /// Reads the pixel at a position that may be outside by at most the viewport's width or height. The
    /// position is mirrored at the centres of the outermost pixels, so that its parity is right. In a
    /// row or column of one pixel, it is that pixel, of the wrong parity.
    ///
    /// Additive blending can overflow, and a target into which another pass has drawn can have any
    /// content: the luminance is clamped to 0 to 65504, and NaN or an infinite chrominance becomes 0.
    pub fn read(&self, x: i64, y: i64) -> PackedPixel {
        let x = mirrored(x, self.size[0]);
        let y = mirrored(y, self.size[1]);
        let pixel = self.pixels[y as usize * self.size[0] as usize + x as usize];
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        if self.format == PackedFormat::Unorm8 {
            // Such a target has no other values than those of 0 to 1.
            return unorm8::decoded(pixel);
        }
        let luminance = if pixel.luminance == f32::INFINITY {
            F16_MAX
        } else {
            finite(pixel.luminance).max(0.0)
        };
        // Additive blending can exceed the largest half: the colour is darkened and keeps its hue.
        let scale = F16_MAX / luminance.max(F16_MAX);
        PackedPixel {
            luminance: luminance * scale,
            chrominance: finite(pixel.chrominance) * scale,
        }
    }
}

/// Mirrors a coordinate at 0 and `length - 1`.
pub fn mirrored(coordinate: i64, length: u32) -> u32 {
    let last = i64::from(length) - 1;
    let from_zero = coordinate.abs();
    (last - (last - from_zero).abs()).max(0) as u32
}

pub mod unorm8 {
    //! Packing for the 8-bit format, and its codes.
    //!
    //! Steps of equal size, as the thesis has them (4.7.2), are as large as those of an 8-bit display, and the rounding of
    //! luminance and of two chrominances adds up. Where errors are seen first, in the dark and near gray, these codes
    //! have steps of a third of that; steps of white and of the most saturated colours are three times as large.

    use super::{PackedPixel, pack, sanitized, srgb_from_linear};

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

//! Conversion of RGB to YCoCg and back (thesis, eq. 3.3).

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

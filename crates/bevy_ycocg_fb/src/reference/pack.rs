//! A fragment's colour to a packed pixel (thesis, listing 4.1).

use super::{
    color::{srgb_from_linear, ycocg_from_rgb},
    storage::F16_MAX,
};

/// Luminance and one chrominance: Co where `x + y` is even, else Cg, of the pixel's position in
/// its target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PackedPixel {
    /// Luminance.
    pub luminance: f32,
    /// Co or Cg; in the 8-bit format plus one half.
    pub chrominance: f32,
}

/// Added to a chrominance in the 8-bit format. One half as the thesis has it (4.7.2) lies between
/// two of the 256 values, and grey would get a tint: this is the nearest of them.
pub const UNORM8_BIAS: f32 = 128.0 / 255.0;

/// Whether the pixel at this position of its target stores Co rather than Cg.
pub fn stores_co(x: u32, y: u32) -> bool {
    (x ^ y) & 1 == 0
}

/// What a material may have made of a colour, to what can be stored: NaN becomes 0, and all else is
/// clamped to 0 to 65504.
///
/// One pixel of NaN or infinity would otherwise spread through filters, bloom and temporal
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

/// Packs a display-linear colour of 0 to 1 for the 8-bit format: sRGB-encoded, with
/// [`UNORM8_BIAS`].
pub fn pack_unorm8(rgb: [f32; 3], x: u32, y: u32) -> PackedPixel {
    let encoded = sanitized(rgb).map(|channel| srgb_from_linear(channel.min(1.0)));
    let packed = pack(encoded, x, y);
    PackedPixel {
        chrominance: packed.chrominance + UNORM8_BIAS,
        ..packed
    }
}

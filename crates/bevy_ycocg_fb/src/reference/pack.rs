//! Packing of a fragment's colour (thesis, listing 4.1).

use super::color::ycocg_from_rgb;

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

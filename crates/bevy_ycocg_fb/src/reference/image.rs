//! A packed viewport, with mirrored neighbours beyond its border.

use super::{
    pack::{F16_MAX, PackedPixel, pack, stores_co},
    storage::{stored, unorm8},
};
use crate::settings::PackedFormat;

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

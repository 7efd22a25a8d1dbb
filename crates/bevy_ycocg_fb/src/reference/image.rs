//! A packed viewport, and its neighbours beyond the border.

use super::{
    color::linear_from_srgb,
    pack::{PackedPixel, UNORM8_BIAS, pack, pack_unorm8, stores_co},
    reconstruct::reconstruct,
    storage::{F16_MAX, stored},
};
use crate::settings::{PackedFormat, Reconstruction};

/// A viewport of packed pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedImage {
    /// Position of its first pixel in the target, in pixels: what decides on parity.
    pub offset: [u32; 2],
    /// Width and height in pixels, both at least 1.
    pub size: [u32; 2],
    /// How the pixels are stored.
    pub format: PackedFormat,
    /// The pixels, row after row from the top left.
    pub pixels: Vec<PackedPixel>,
}

impl PackedImage {
    /// Packs colours as a viewport at `offset` would store them: scene-linear ones for the float
    /// formats, display-linear ones for the 8-bit format.
    pub fn pack(
        colors: &[[f32; 3]],
        size: [u32; 2],
        offset: [u32; 2],
        format: PackedFormat,
    ) -> Self {
        let pack = match format {
            PackedFormat::Float16 | PackedFormat::Float32 => pack,
            PackedFormat::Unorm8 => pack_unorm8,
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

    /// Reconstructs every pixel, in the units that went into [`pack`](Self::pack).
    pub fn unpack(&self, filter: Reconstruction) -> Vec<[f32; 3]> {
        let positions = (0..self.size[1]).flat_map(|y| (0..self.size[0]).map(move |x| (x, y)));
        let colors = positions.map(|(x, y)| reconstruct(self, x, y, filter));
        match self.format {
            PackedFormat::Float16 | PackedFormat::Float32 => colors.collect(),
            PackedFormat::Unorm8 => colors
                .map(|color| color.map(|c| linear_from_srgb(c.clamp(0.0, 1.0))))
                .collect(),
        }
    }

    /// Whether this pixel of the viewport stores Co rather than Cg.
    pub fn stores_co(&self, x: u32, y: u32) -> bool {
        stores_co(self.offset[0] + x, self.offset[1] + y)
    }

    /// The pixel at a position that may lie outside by at most a viewport's width or height:
    /// mirrored at the centres of the outermost pixels, so that its parity is right. Where there is
    /// no other pixel to mirror to, it is the only one, of the wrong parity.
    ///
    /// Additive blending can overflow, and a target that another pass has drawn to can hold
    /// anything: the luminance is brought to 0 to 65504, and what is not a number is 0.
    pub fn read(&self, x: i64, y: i64) -> PackedPixel {
        let x = mirrored(x, self.size[0]);
        let y = mirrored(y, self.size[1]);
        let pixel = self.pixels[y as usize * self.size[0] as usize + x as usize];
        let bias = match self.format {
            PackedFormat::Float16 | PackedFormat::Float32 => 0.0,
            PackedFormat::Unorm8 => UNORM8_BIAS,
        };
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        let luminance = if pixel.luminance == f32::INFINITY {
            F16_MAX
        } else {
            finite(pixel.luminance).max(0.0)
        };
        // Too bright by additive blending: darker, of the same hue.
        let scale = F16_MAX / luminance.max(F16_MAX);
        PackedPixel {
            luminance: luminance * scale,
            chrominance: (finite(pixel.chrominance) - bias) * scale,
        }
    }
}

/// A coordinate mirrored at 0 and `length - 1`.
pub fn mirrored(coordinate: i64, length: u32) -> u32 {
    let last = i64::from(length) - 1;
    let from_zero = coordinate.abs();
    (last - (last - from_zero).abs()).max(0) as u32
}

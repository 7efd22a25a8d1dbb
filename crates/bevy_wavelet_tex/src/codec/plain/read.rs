//! What a texture unit reads from a plain texture.

use rayon::prelude::*;

use super::texture::PlainTexture;
use crate::codec::{blocks::BlockFormat, interpolation::Axis, layout};

/// The four channels of an image of `image_size` at a mip level: the texture at the centres of the
/// level's pixels.
pub(in crate::codec) fn pixels(
    plain: &PlainTexture,
    image_size: [u32; 2],
    level: u32,
    decode_blocks: impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> Vec<[f32; 4]> {
    let size = layout::mip_size(image_size, level);
    let texture = plain.level_size(level);
    let texels = decode_blocks(plain.format, plain.level_blocks(level), texture);
    let axes = [0, 1].map(|i: usize| Axis::stretched(size[i], texture[i]));
    let rows = Rows::new(texels, 0, axes);
    (0..size[0] * size[1])
        .into_par_iter()
        .map(|i| rows.pixel(i % size[0], i / size[0]))
        .collect()
}

/// Consecutive rows of a texture, from which pixels are read.
pub(super) struct Rows {
    texels: Vec<[f32; 4]>,
    first: u32,
    axes: [Axis; 2],
}

impl Rows {
    /// `first` is the number of the first row, `axes` are where pixels lie among all texels.
    pub(super) fn new(texels: Vec<[f32; 4]>, first: u32, axes: [Axis; 2]) -> Self {
        Self {
            texels,
            first,
            axes,
        }
    }

    /// Whether all texels that a row of pixels needs are in these rows.
    pub(super) fn have(&self, y: u32) -> bool {
        let (above, below, _) = self.axes[1].taps(y);
        let rows = self.texels.len() as u32 / self.axes[0].texels;
        above >= self.first && below < self.first + rows
    }

    /// The four channels at a pixel.
    pub(super) fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        let (left, right, u) = self.axes[0].taps(x);
        let (above, below, v) = self.axes[1].taps(y);
        let texel = |x, y| &self.texels[((y - self.first) * self.axes[0].texels + x) as usize];
        let corners = [
            texel(left, above),
            texel(right, above),
            texel(left, below),
            texel(right, below),
        ];
        std::array::from_fn(|c| {
            let [a, b, c, d] = corners.map(|texel| texel[c]);
            let (top, bottom) = (a + (b - a) * u, c + (d - c) * u);
            top + (bottom - top) * v
        })
    }
}

//! What a texture unit reads from a plain texture.

use rayon::prelude::*;

use super::PlainTexture;
use crate::codec::{
    blocks::BlockFormat,
    decoder::{DecodedImage, normal_from_xy},
    image::{Content, WaveletImage},
    interpolation::Axis,
    layout,
};

/// Decodes a mip level: its pixels are where the centres of pixels of that level lie in the texture.
pub(in crate::codec) fn decode(
    image: &WaveletImage,
    plain: &PlainTexture,
    level: u32,
    decode_blocks: impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> DecodedImage {
    let size = layout::mip_size(image.size, level);
    let texture = plain.level_size(level);
    let texels = decode_blocks(plain.format, plain.level_blocks(level), texture);
    let axes = [0, 1].map(|i: usize| Axis::stretched(size[i], texture[i]));
    let rows = Rows::new(texels, 0, axes);
    let read = |i: u32| rows.pixel(i % size[0], i / size[0]);
    let values: Vec<[f32; 4]> = (0..size[0] * size[1]).into_par_iter().map(read).collect();
    let pixel = |[r, g, b, _]: &[f32; 4]| match image.content {
        Content::Gray => [*r; 3],
        Content::Color | Content::ColorAlpha => [*r, *g, *b],
        Content::Normal => normal_from_xy([2.0 * r - 1.0, 2.0 * g - 1.0]),
    };
    DecodedImage {
        size,
        pixels: values.iter().map(pixel).collect(),
        alpha: (image.content == Content::ColorAlpha)
            .then(|| values.iter().map(|v| v[3]).collect()),
    }
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

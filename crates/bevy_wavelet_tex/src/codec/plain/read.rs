//! What a texture unit reads from a plain texture.

use super::texture::PlainTexture;
use crate::codec::{
    blocks::BlockFormat,
    interpolation::{Axis, Tap},
    layout,
};

/// The four channels of an image at a mip level, row by row: the texture at the centres of the level's pixels.
pub(in crate::codec) struct PlainRows {
    texels: Vec<[f32; 4]>,
    width: usize,
    across: Vec<Tap>,
    down: Axis,
}

impl PlainRows {
    pub(in crate::codec) fn new(
        plain: &PlainTexture,
        image_size: [u32; 2],
        level: u32,
        decode_blocks: impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
    ) -> Self {
        let size = layout::mip_size(image_size, level);
        let texture = plain.level_size(level);
        let [across, down] = PlainTexture::axes(size, texture, plain.is_scaled(image_size));
        Self {
            texels: decode_blocks(plain.format, plain.level_blocks(level), texture),
            width: texture[0] as usize,
            across: across.all_taps(),
            down,
        }
    }

    pub(in crate::codec) fn fill(&self, y: u32, row: &mut [[f32; 4]]) {
        let (above, below, v) = self.down.taps(y);
        let line = |y: u32| &self.texels[y as usize * self.width..][..self.width];
        let pairs = line(above).iter().zip(line(below));
        let blended: Vec<[f32; 4]> = pairs.map(|(a, b)| mix(*a, *b, v)).collect();
        for (pixel, &(left, right, u)) in row.iter_mut().zip(&self.across) {
            *pixel = mix(blended[left as usize], blended[right as usize], u);
        }
    }
}

/// Interpolates the four channels of two texels.
pub(super) fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

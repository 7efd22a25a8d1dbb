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
    let mut pixels = vec![[0.0; 4]; size[0] as usize * size[1] as usize];
    let lines = pixels.par_chunks_mut(size[0] as usize).enumerate();
    lines.for_each(|(y, line)| {
        let row = rows.row(y as u32);
        line.iter_mut()
            .zip(row)
            .for_each(|(pixel, read)| *pixel = read);
    });
    pixels
}

/// Consecutive rows of a texture, from which pixels are read.
pub(super) struct Rows {
    texels: Vec<[f32; 4]>,
    first: u32,
    axes: [Axis; 2],
    /// Where the pixels of a row lie.
    across: Vec<(u32, u32, f32)>,
}

impl Rows {
    /// `first` is the number of the first row, `axes` are where pixels lie among all texels.
    pub(super) fn new(texels: Vec<[f32; 4]>, first: u32, axes: [Axis; 2]) -> Self {
        Self {
            texels,
            first,
            axes,
            across: (0..axes[0].pixels).map(|x| axes[0].taps(x)).collect(),
        }
    }

    /// Whether all texels that a row of pixels needs are in these rows.
    pub(super) fn have(&self, y: u32) -> bool {
        let (above, below, _) = self.axes[1].taps(y);
        let rows = self.texels.len() as u32 / self.axes[0].texels;
        above >= self.first && below < self.first + rows
    }

    /// The four channels at the pixels of a row.
    pub(super) fn row(&self, y: u32) -> impl Iterator<Item = [f32; 4]> {
        let (above, below, v) = self.axes[1].taps(y);
        let width = self.axes[0].texels as usize;
        let texels = |y: u32| &self.texels[(y - self.first) as usize * width..][..width];
        let pairs = texels(above).iter().zip(texels(below));
        let blended: Vec<[f32; 4]> = pairs.map(|(a, b)| mix(*a, *b, v)).collect();
        let pixel = move |&(left, right, u): &(u32, u32, f32)| {
            mix(blended[left as usize], blended[right as usize], u)
        };
        self.across.iter().map(pixel)
    }
}

fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

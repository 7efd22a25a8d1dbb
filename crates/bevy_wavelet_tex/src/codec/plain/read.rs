//! What a texture unit reads from a plain texture.

use rayon::prelude::*;

use super::texture::PlainTexture;
use crate::codec::{blocks::BlockFormat, layout};

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
    let axes = PlainTexture::axes(size, texture, plain.is_scaled(image_size));
    let [across, down] = axes.map(|axis| axis.all_taps());
    let mut pixels = vec![[0.0; 4]; size[0] as usize * size[1] as usize];
    let rows = pixels.par_chunks_mut(size[0] as usize).zip(down);
    rows.for_each(|(row, (above, below, v))| {
        let line = |y: u32| texels[(y * texture[0]) as usize..].iter();
        let pairs = line(above).zip(line(below)).take(texture[0] as usize);
        let blended: Vec<[f32; 4]> = pairs.map(|(a, b)| mix(*a, *b, v)).collect();
        for (pixel, &(left, right, u)) in row.iter_mut().zip(&across) {
            *pixel = mix(blended[left as usize], blended[right as usize], u);
        }
    });
    pixels
}

/// Interpolates the four channels of two texels.
pub(super) fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

//! Textures without a wavelet: the pixels themselves in BC1, BC4, BC5 or BC7, at full size or
//! smaller, which the texture unit filters by itself. At full size, an image whose sides are no whole blocks
//! is padded with its outermost pixels; the texture unit cannot filter across its edges, so the shader
//! filters it as it does wavelets. Resampled to the next smaller size in whole blocks, game textures lose 0.6
//! to 4 dB in BC1 and 4 to 20 in BC7.
//!
//! They are what a game has today, and better than a wavelet where an image has hardly anything that
//! a wavelet predicts: saturated edges, text, channels that have nothing in common. The encoder
//! measures them beside the wavelet and keeps what has the least error, so that no image
//! at any rate is worse than they are. A smaller texture has the texels whose interpolation comes
//! closest to the image, which is better than a smaller image that a bicubic filter magnifies.
//!
//! A smaller texture is interpolated as it is stored and linearised after that, which comes 0.2 to 1.5
//! dB closer to game textures than interpolation in linear light. At full size, where a pixel is a
//! texel, the texture unit filters colour in linear light, as it does all sRGB textures; gray it does
//! not, since BC4 has no sRGB variant. The shader filters what is padded in linear light.

#[cfg(feature = "encode")]
mod choose;
#[cfg(feature = "encode")]
mod encode;

use super::{
    blocks::BlockFormat,
    image::{ColorSpace, Content},
    interpolation::{Axis, Tap},
    layout,
};
#[cfg(feature = "encode")]
pub(super) use choose::better;
#[cfg(feature = "encode")]
pub(super) use encode::{Channels, add_level};

/// The texture of an image without a wavelet.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainTexture {
    /// Format of the blocks, one of [`PlainTexture::formats`].
    pub format: BlockFormat,
    /// Width and height of the largest level in texels: whole blocks, and no more than cover the image.
    pub size: [u32; 2],
    /// The blocks of all mip levels from the largest.
    pub blocks: Vec<u8>,
}

impl PlainTexture {
    /// The formats that can hold a content: gray in BC4, normals in BC5, colour in BC1 and BC7, colour
    /// with alpha in BC7 (BC3 takes as many bits and is worse).
    pub fn formats(content: Content) -> &'static [BlockFormat] {
        match content {
            Content::Gray => &[BlockFormat::Bc4],
            Content::Color => &[BlockFormat::Bc1, BlockFormat::Bc7],
            Content::ColorAlpha => &[BlockFormat::Bc7],
            Content::Normal => &[BlockFormat::Bc5],
        }
    }

    /// The size of a texture that has a texel for each pixel of an image, in whole blocks.
    pub fn full_size(image_size: [u32; 2]) -> [u32; 2] {
        image_size.map(|s| s.next_multiple_of(4))
    }

    /// Returns whether a texture of `size` texels can be that of an image of `image_size` pixels.
    pub fn is_valid_size(size: [u32; 2], image_size: [u32; 2]) -> bool {
        let fits = |(texels, most): (u32, u32)| texels > 0 && texels % 4 == 0 && texels <= most;
        size.into_iter().zip(Self::full_size(image_size)).all(fits)
    }

    /// The largest sizes of textures of a format that take at most `bytes` for an image, in whole
    /// blocks: with both sides scaled alike, and with one of them scaled alone. There is none where not
    /// a block fits.
    pub fn sizes_within(image_size: [u32; 2], format: BlockFormat, bytes: usize) -> Vec<[u32; 2]> {
        let [columns, rows] = Self::full_size(image_size).map(|s| s as usize / 4);
        let blocks = bytes / format.block_bytes();
        let area = blocks as f64 / (columns * rows) as f64;
        let mut sizes = Vec::new();
        for scale in [area.sqrt(), 1.0, area] {
            let across = ((columns as f64 * scale) as usize).clamp(1, columns);
            let size = [across, (blocks / across).min(rows)].map(|blocks| 4 * blocks as u32);
            if Self::is_valid_size(size, image_size) && !sizes.contains(&size) {
                sizes.push(size);
            }
        }
        sizes
    }

    /// Largest number of mip levels of a texture of an image, both of which have them down to one texel or
    /// pixel.
    pub fn max_level_count(size: [u32; 2], image_size: [u32; 2]) -> u32 {
        layout::level_count(size).min(layout::level_count(image_size))
    }

    /// Returns whether the texture unit linearises texels, before it interpolates them.
    pub fn is_srgb(&self, content: Content, color_space: ColorSpace, image_size: [u32; 2]) -> bool {
        color_space == ColorSpace::Srgb && content.has_chroma() && !self.is_scaled(image_size)
    }

    /// Returns whether the texture has fewer texels than an image of `image_size` has pixels.
    pub fn is_scaled(&self, image_size: [u32; 2]) -> bool {
        self.size != Self::full_size(image_size)
    }

    /// Returns whether a texel is a pixel of an image of `image_size` whose sides are no whole blocks. There
    /// are more texels beyond its last row or column, so the texture unit cannot repeat the image, and
    /// decoders read pixels one by one.
    pub fn is_padded(&self, image_size: [u32; 2]) -> bool {
        self.size != image_size && !self.is_scaled(image_size)
    }

    /// Where the pixels of a level lie among its texels.
    fn axes(pixels: [u32; 2], texels: [u32; 2], is_scaled: bool) -> [Axis; 2] {
        [0, 1].map(|i: usize| {
            if is_scaled {
                Axis::stretched(pixels[i], texels[i])
            } else {
                Axis::halved(pixels[i], 0)
            }
        })
    }

    /// Size of a mip level in texels.
    pub fn level_size(&self, level: u32) -> [u32; 2] {
        layout::mip_size(self.size, level)
    }

    /// The blocks of a mip level.
    pub fn level_blocks(&self, level: u32) -> &[u8] {
        &self.blocks[self.bytes_before(level)..self.bytes_before(level + 1)]
    }

    /// Bytes of the levels before this one.
    pub(super) fn bytes_before(&self, level: u32) -> usize {
        let bytes = |level| self.format.level_bytes(self.level_size(level));
        (0..level).map(bytes).sum()
    }
}

/// The four channels of an image at a mip level, row by row: the texture at the centres of the level's pixels.
pub(super) struct PlainRows {
    texels: Vec<[f32; 4]>,
    width: usize,
    across: Vec<Tap>,
    down: Axis,
}

impl PlainRows {
    pub(super) fn new(
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

    pub(super) fn fill(&self, y: u32, row: &mut [[f32; 4]]) {
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
fn mix(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_take_the_bytes_and_no_more() {
        for image in [
            [512, 512],
            [1024, 256],
            [768, 512],
            [93, 61],
            [4, 4],
            [3, 9],
            [17, 300],
        ] {
            let full = PlainTexture::full_size(image);
            for format in [BlockFormat::Bc1, BlockFormat::Bc7] {
                let most = format.level_bytes(full);
                for bytes in [
                    1,
                    8,
                    16,
                    40,
                    most / 2,
                    most * 2 / 3,
                    most - 1,
                    most,
                    2 * most,
                ] {
                    let sizes = PlainTexture::sizes_within(image, format, bytes);
                    assert_eq!(sizes.is_empty(), bytes < format.block_bytes());
                    for &size in &sizes {
                        assert!(format.level_bytes(size) <= bytes, "{image:?}: {size:?}");
                        assert!(PlainTexture::is_valid_size(size, image));
                    }
                    if bytes >= most {
                        assert_eq!(sizes, [full]);
                    }
                }
            }
        }
        let of = |image, bytes| PlainTexture::sizes_within(image, BlockFormat::Bc1, bytes);
        let bytes = 512 * 512 * 9 / 32;
        let sizes = [[384, 384], [512, 288], [288, 512]];
        assert_eq!(of([512, 512], bytes), sizes);
        assert_eq!(of([144, 24], 1296), [[124, 20], [144, 16], [108, 24]]);
        assert_eq!(of([3, 9], 16), [[4, 8]]);
    }

    #[test]
    fn levels_end_at_one_pixel_and_at_one_texel() {
        assert_eq!(PlainTexture::max_level_count([64, 32], [93, 61]), 7);
        assert_eq!(PlainTexture::max_level_count([96, 64], [93, 61]), 7);
        assert_eq!(PlainTexture::max_level_count([4, 4], [1, 3]), 2);
        assert_eq!(PlainTexture::max_level_count([8, 4], [7, 1]), 3);
    }
}

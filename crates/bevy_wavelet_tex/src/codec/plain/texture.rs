//! The texture of an image without a wavelet.

use crate::codec::{
    blocks::BlockFormat,
    content::{ColorSpace, Content},
    layout,
};

/// The texture of an image without a wavelet.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainTexture {
    /// Format of the blocks, one of [`PlainTexture::formats`].
    pub format: BlockFormat,
    /// Width and height of the largest level in texels: whole blocks, and no more than the pixels of
    /// the image.
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

    /// Returns whether a texture of `size` texels can be that of an image of `image_size` pixels.
    pub fn is_valid_size(size: [u32; 2], image_size: [u32; 2]) -> bool {
        let fits = |(texels, pixels): (u32, u32)| texels > 0 && texels % 4 == 0 && texels <= pixels;
        size.into_iter().zip(image_size).all(fits)
    }

    /// The largest sizes of textures of a format that take at most `bits` per pixel of an image, in whole
    /// blocks: with both sides scaled alike, and with one of them scaled alone. There is none where not
    /// a block fits.
    pub fn sizes_within(image: [u32; 2], format: BlockFormat, bits: f64) -> Vec<[u32; 2]> {
        let whole_blocks = |texels: f64| texels as u32 / 4 * 4;
        let area = bits / (format.block_bytes() as f64 / 2.0);
        let [width, height] = image.map(f64::from);
        let mut sizes = Vec::new();
        for scale in [area.sqrt(), 1.0, area] {
            let w = whole_blocks(width * scale.min(1.0));
            let h = whole_blocks((width * height * area / f64::from(w)).min(height));
            if Self::is_valid_size([w, h], image) && !sizes.contains(&[w, h]) {
                sizes.push([w, h]);
            }
        }
        sizes
    }

    /// Number of mip levels down to one texel.
    pub fn max_level_count(size: [u32; 2]) -> u32 {
        32 - size[0].max(size[1]).leading_zeros()
    }

    /// Returns whether the texture unit linearises texels, before it interpolates them.
    pub fn is_srgb(&self, content: Content, color_space: ColorSpace, image_size: [u32; 2]) -> bool {
        color_space == ColorSpace::Srgb && content.has_chroma() && !self.is_scaled(image_size)
    }

    /// Returns whether the texture has fewer texels than an image of `image_size` has pixels.
    pub fn is_scaled(&self, image_size: [u32; 2]) -> bool {
        self.size != image_size
    }

    /// Size of a mip level in texels.
    pub fn level_size(&self, level: u32) -> [u32; 2] {
        layout::mip_size(self.size, level)
    }

    /// The blocks of a mip level.
    pub fn level_blocks(&self, level: u32) -> &[u8] {
        let bytes = |level| self.format.level_bytes(self.level_size(level));
        let start = (0..level).map(bytes).sum::<usize>();
        &self.blocks[start..start + bytes(level)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_take_the_bits_and_no_more() {
        for image in [
            [512, 512],
            [1024, 256],
            [768, 512],
            [93, 61],
            [4, 4],
            [17, 300],
        ] {
            for bits in [2.0, 2.25, 3.0, 3.25, 4.0, 5.0, 8.0] {
                for format in [BlockFormat::Bc1, BlockFormat::Bc7] {
                    let sizes = PlainTexture::sizes_within(image, format, bits);
                    assert!(!sizes.is_empty() || image.contains(&4) || image == [17, 300]);
                    for &size in &sizes {
                        let pixels = f64::from(image[0] * image[1]);
                        let taken = 8.0 * format.level_bytes(size) as f64 / pixels;
                        assert!(taken <= bits, "{image:?} {bits}: {size:?}");
                        assert!(PlainTexture::is_valid_size(size, image));
                    }
                    let whole = image.iter().all(|s| s % 4 == 0);
                    if whole && bits >= format.block_bytes() as f64 / 2.0 {
                        assert_eq!(sizes, [image]);
                    }
                }
            }
        }
        let of = |image, bits| PlainTexture::sizes_within(image, BlockFormat::Bc1, bits);
        assert_eq!(of([512, 512], 2.25), [[384, 384], [512, 288], [288, 512]]);
        assert_eq!(of([3, 9], 4.0), [[0; 2]; 0]);
        assert_eq!(of([144, 24], 3.0), [[124, 20], [144, 16], [108, 24]]);
    }
}

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

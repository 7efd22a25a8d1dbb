//! What the codec codes: the wavelet image and its parts.

use serde::{Deserialize, Serialize};

use super::{layout, quantizer::PlaneCoding};

/// What an image holds, and so into which planes it is taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Content {
    /// One channel: 2 bits per pixel.
    Gray,
    /// Colour as luma and half-size chroma: 3 bits per pixel.
    Color,
    /// X and Y of unit normals in tangent space, Z rebuilt: 4 bits per pixel.
    Normal,
}

impl Content {
    /// Plane groups: how often each is halved against the image, and how many planes it has.
    pub fn groups(self) -> &'static [GroupShape] {
        match self {
            Self::Gray => &[GroupShape {
                subsampling: 0,
                planes: 1,
            }],
            Self::Color => &[
                GroupShape {
                    subsampling: 0,
                    planes: 1,
                },
                GroupShape {
                    subsampling: 1,
                    planes: 2,
                },
            ],
            Self::Normal => &[GroupShape {
                subsampling: 0,
                planes: 2,
            }],
        }
    }

    /// Bits per pixel of large images without mips.
    pub fn nominal_bits_per_pixel(self) -> f64 {
        let bits = |g: &GroupShape| 2.0 * g.planes as f64 / f64::from(1 << (2 * g.subsampling));
        self.groups().iter().map(bits).sum()
    }
}

/// The shape of a group of planes that share a size, and so one array texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GroupShape {
    /// How often the image is halved (rounded up) to get the planes' size.
    pub subsampling: u32,
    /// Number of planes: 1 or 2, the layers of the array texture.
    pub planes: usize,
}

/// How the values of an image relate to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorSpace {
    /// sRGB-encoded colour: decoded, then linearised, then filtered.
    Srgb,
    /// Data (masks, normals): filtered as they are.
    Linear,
}

/// An encoded image.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveletImage {
    /// What it holds.
    pub content: Content,
    /// How its values relate to light.
    pub color_space: ColorSpace,
    /// Width and height in pixels, each in `1..=`[`layout::MAX_SIZE`].
    pub size: [u32; 2],
    /// Number of mip levels, the same in all groups; at least 1.
    pub levels: u32,
    /// The planes, in the order and shape of [`Content::groups`].
    pub groups: Vec<PlaneGroup>,
}

/// The planes of one size: one BC3 array texture, a layer for each plane.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneGroup {
    /// How each plane's coefficients are stored.
    pub codings: Vec<PlaneCoding>,
    /// BC3 blocks: level by level from the largest, in each level layer by layer.
    pub blocks: Vec<u8>,
}

impl WaveletImage {
    /// Size of the coefficient texture of a group, in texels.
    pub fn texture_size(&self, group: usize) -> [u32; 2] {
        let shape = self.content.groups()[group];
        layout::texture_size(layout::plane_size(self.size, shape.subsampling))
    }

    /// The BC3 blocks of one level of one layer of a group.
    pub fn level_blocks(&self, group: usize, level: u32, layer: usize) -> &[u8] {
        let texture = self.texture_size(group);
        let planes = self.content.groups()[group].planes;
        let bytes = |level| layout::level_bytes(layout::mip_size(texture, level));
        let start = planes * (0..level).map(bytes).sum::<usize>() + layer * bytes(level);
        &self.groups[group].blocks[start..start + bytes(level)]
    }

    /// Bytes of all blocks: what the textures take on the GPU.
    pub fn gpu_bytes(&self) -> usize {
        self.groups.iter().map(|g| g.blocks.len()).sum()
    }

    /// Bits per pixel of the largest level, padding included.
    pub fn bits_per_pixel(&self) -> f64 {
        let level_0 = |(i, shape): (usize, &GroupShape)| {
            shape.planes * layout::level_bytes(self.texture_size(i))
        };
        let bytes: usize = self.content.groups().iter().enumerate().map(level_0).sum();
        8.0 * bytes as f64 / (f64::from(self.size[0]) * f64::from(self.size[1]))
    }
}

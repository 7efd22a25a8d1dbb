//! What the codec codes: the wavelet image and its parts.

use serde::{Deserialize, Serialize};

use super::{blocks::BlockFormat, layout, quantizer::PlaneCoding};

/// What an image holds, and so into which planes it is taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Content {
    /// One channel.
    Gray,
    /// Colour as luma and smaller chroma.
    Color,
    /// The same with an alpha channel, stored as luma is.
    ColorAlpha,
    /// X and Y of unit normals in tangent space, Z rebuilt.
    Normal,
}

impl Content {
    /// Planes of the luma group: the layers of its textures.
    pub fn luma_planes(self) -> usize {
        match self {
            Self::Gray | Self::Color => 1,
            Self::ColorAlpha | Self::Normal => 2,
        }
    }

    /// Whether there is a chroma group.
    pub fn has_chroma(self) -> bool {
        matches!(self, Self::Color | Self::ColorAlpha)
    }
}

/// How the planes of a group are packed into textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Packing {
    /// Wavelet, 2 bpp: details in RGB of BC3, the mean in alpha, which is coded on its own.
    Bc3,
    /// Wavelet, 2 bpp: HL, LH and the mean in RGB of BC7, HH dropped (thesis section 3.5.1).
    Bc7,
    /// Wavelet, 3 bpp: the mean in BC4, the details in a BC7 texture of their own.
    Split,
    /// The plane as it is in BC4, 4 bpp.
    Bc4,
    /// Two planes as they are in one BC1 texture, 4 bpp: the first in R and B, whose mean has a bit
    /// more, the second in G. Interpolated between their pixels.
    Bc1,
}

impl Packing {
    /// All of them, in the order of their numbers in files.
    pub const ALL: [Self; 5] = [Self::Bc3, Self::Bc7, Self::Split, Self::Bc4, Self::Bc1];

    /// The formats of its textures.
    pub fn formats(self) -> &'static [BlockFormat] {
        match self {
            Self::Bc3 => &[BlockFormat::Bc3],
            Self::Bc7 => &[BlockFormat::Bc7],
            Self::Split => &[BlockFormat::Bc4, BlockFormat::Bc7],
            Self::Bc4 => &[BlockFormat::Bc4],
            Self::Bc1 => &[BlockFormat::Bc1],
        }
    }

    /// Whether a texel holds the coefficients of 2 x 2 pixels, and not a pixel.
    pub fn is_wavelet(self) -> bool {
        matches!(self, Self::Bc3 | Self::Bc7 | Self::Split)
    }

    /// Layers of its textures for that many planes.
    pub fn layers(self, planes: usize) -> usize {
        if self == Self::Bc1 { 1 } else { planes }
    }

    /// Of one layer, for each pixel of the plane.
    pub fn bits_per_pixel(self) -> f64 {
        let bits = |f: &BlockFormat| 8.0 * f.block_bytes() as f64 / 16.0;
        let texels: f64 = if self.is_wavelet() { 0.25 } else { 1.0 };
        texels * self.formats().iter().map(bits).sum::<f64>()
    }

    /// As the tool calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bc3 => "bc3",
            Self::Bc7 => "bc7",
            Self::Split => "bc4+bc7",
            Self::Bc4 => "bc4",
            Self::Bc1 => "bc1",
        }
    }
}

/// How the values of an image relate to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorSpace {
    /// sRGB-encoded colour: decoded, then linearised, then filtered.
    #[default]
    Srgb,
    /// Data (masks, normals): filtered as they are.
    Linear,
}

/// An encoded image.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveletImage {
    /// What it holds.
    pub content: Content,
    /// How its values relate to light; alpha is always linear.
    pub color_space: ColorSpace,
    /// Width and height in pixels, each in `1..=`[`layout::MAX_SIZE`].
    pub size: [u32; 2],
    /// Number of mip levels, the same in all groups; at least 1.
    pub levels: u32,
    /// Luma (with alpha), gray, or X and Y of normals; then chroma, if there is any.
    pub groups: Vec<PlaneGroup>,
}

/// The planes of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneGroup {
    /// How often the image is halved (rounded up) to get the planes' size: 0 to 2.
    pub subsampling: u32,
    /// How the planes are packed.
    pub packing: Packing,
    /// How the values of each plane are stored.
    pub codings: Vec<PlaneCoding>,
    /// The blocks of each of the packing's textures: level by level from the largest, in each level
    /// layer by layer.
    pub textures: Vec<Vec<u8>>,
}

impl PlaneGroup {
    /// Size of the planes at a mip level of an image of that size.
    pub fn plane_size(&self, image_size: [u32; 2], level: u32) -> [u32; 2] {
        layout::plane_size(layout::mip_size(image_size, level), self.subsampling)
    }

    /// Size of the textures' largest level, in texels.
    pub fn texture_size(&self, image_size: [u32; 2]) -> [u32; 2] {
        layout::texture_size(self.packing, self.plane_size(image_size, 0))
    }

    /// Layers of the textures.
    pub fn layers(&self) -> usize {
        self.packing.layers(self.codings.len())
    }
}

impl WaveletImage {
    /// The blocks of one level of one layer of a texture.
    pub fn level_blocks(&self, group: usize, texture: usize, level: u32, layer: usize) -> &[u8] {
        let group = &self.groups[group];
        let format = group.packing.formats()[texture];
        let size = group.texture_size(self.size);
        let bytes = |level| format.level_bytes(layout::mip_size(size, level));
        let start = group.layers() * (0..level).map(bytes).sum::<usize>() + layer * bytes(level);
        &group.textures[texture][start..start + bytes(level)]
    }

    /// Bytes of all blocks: what the textures take on the GPU.
    pub fn gpu_bytes(&self) -> usize {
        let textures = self.groups.iter().flat_map(|g| &g.textures);
        textures.map(Vec::len).sum()
    }

    /// Bits per pixel of the largest level, padding included.
    pub fn bits_per_pixel(&self) -> f64 {
        let level_0 = |g: &PlaneGroup| {
            let size = g.texture_size(self.size);
            let bytes = |f: &BlockFormat| f.level_bytes(size);
            g.layers() * g.packing.formats().iter().map(bytes).sum::<usize>()
        };
        let bytes: usize = self.groups.iter().map(level_0).sum();
        8.0 * bytes as f64 / (f64::from(self.size[0]) * f64::from(self.size[1]))
    }
}

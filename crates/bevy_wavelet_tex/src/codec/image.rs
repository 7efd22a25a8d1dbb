//! The encoded image and its parts.

use serde::{Deserialize, Serialize};

use super::{
    axes::ColorAxes, decoder::normal_from_xy, layout, packing::Packing, plain::PlainTexture,
    quantizer::PlaneCoding,
};

/// An encoded image with its mips.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveletImage {
    /// The kind of data in the image.
    pub content: Content,
    /// Transfer function of the values; alpha is always linear.
    pub color_space: ColorSpace,
    /// Width and height in pixels, each in `1..=`[`layout::MAX_SIZE`].
    pub size: [u32; 2],
    /// Number of mip levels, the same in all textures; at least 1.
    pub levels: u32,
    /// The textures of the image.
    pub payload: Payload,
}

/// How an image is stored.
#[derive(Clone, Debug, PartialEq)]
pub enum Payload {
    /// As planes, most of which hold the coefficients of a wavelet.
    Wavelet(WaveletPlanes),
    /// As a texture without a wavelet.
    Plain(PlainTexture),
}

/// The planes of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveletPlanes {
    /// The axes of colour along which luma and chroma are stored; those of YCoCg without colour.
    pub axes: ColorAxes,
    /// Luma (with alpha), gray, or X and Y of normals.
    pub luma: PlaneGroup,
    /// Chroma, of images in colour.
    pub chroma: Option<PlaneGroup>,
}

/// Planes of the same size and packing.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneGroup {
    /// How often the image size is halved (rounded up) to get the size of the planes, 0 to 2.
    pub subsampling: u32,
    /// How the planes are packed.
    pub packing: Packing,
    /// How the values of each plane are stored.
    pub codings: Vec<PlaneCoding>,
    /// The blocks of each of the packing's textures: mip levels from the largest, and in each level
    /// layer by layer.
    pub textures: Vec<Vec<u8>>,
}

impl PlaneGroup {
    /// Size of the planes at a mip level of an image of size `image_size`.
    pub fn plane_size(&self, image_size: [u32; 2], level: u32) -> [u32; 2] {
        layout::plane_size(layout::mip_size(image_size, level), self.subsampling)
    }

    /// Size of the textures' largest level in texels, for an image of size `image_size`.
    pub fn texture_size(&self, image_size: [u32; 2]) -> [u32; 2] {
        layout::texture_size(self.packing, self.plane_size(image_size, 0))
    }

    /// Size of a level of the textures in texels, for an image of size `image_size`.
    pub fn texture_level_size(&self, image_size: [u32; 2], level: u32) -> [u32; 2] {
        layout::texture_level_size(self.packing, image_size, self.subsampling, level)
    }

    /// Number of layers of the textures.
    pub fn layers(&self) -> usize {
        self.packing.layers(self.codings.len())
    }

    /// The blocks of one level of one layer of a texture, of an image of size `image_size`.
    pub fn level_blocks(
        &self,
        image_size: [u32; 2],
        texture: usize,
        level: u32,
        layer: usize,
    ) -> &[u8] {
        let bytes =
            self.packing.formats()[texture].level_bytes(self.texture_level_size(image_size, level));
        let start = self.bytes_before(image_size, texture, level) + layer * bytes;
        &self.textures[texture][start..start + bytes]
    }

    /// Bytes of a texture's levels before this one.
    fn bytes_before(&self, image_size: [u32; 2], texture: usize, level: u32) -> usize {
        let format = self.packing.formats()[texture];
        let bytes = |level| format.level_bytes(self.texture_level_size(image_size, level));
        self.layers() * (0..level).map(bytes).sum::<usize>()
    }
}

impl WaveletPlanes {
    /// Luma, then chroma if there is any.
    pub fn groups(&self) -> impl Iterator<Item = &PlaneGroup> {
        std::iter::once(&self.luma).chain(&self.chroma)
    }
}

impl WaveletImage {
    /// The planes of an image that is stored by a wavelet.
    pub fn planes(&self) -> Option<&WaveletPlanes> {
        match &self.payload {
            Payload::Wavelet(planes) => Some(planes),
            Payload::Plain(_) => None,
        }
    }

    /// The groups of these planes.
    pub fn groups(&self) -> impl Iterator<Item = &PlaneGroup> {
        self.planes().into_iter().flat_map(WaveletPlanes::groups)
    }

    /// The texture of an image that is stored without a wavelet.
    pub fn plain(&self) -> Option<&PlainTexture> {
        match &self.payload {
            Payload::Wavelet(_) => None,
            Payload::Plain(plain) => Some(plain),
        }
    }

    /// The axes of colour: those of YCoCg where nothing is stored along others.
    pub fn axes(&self) -> ColorAxes {
        self.planes().map_or(ColorAxes::YCOCG, |planes| planes.axes)
    }

    /// Removes all levels from `level` on, to append others.
    #[cfg(feature = "encode")]
    pub(super) fn truncate(&mut self, level: u32) {
        match &mut self.payload {
            Payload::Wavelet(planes) => {
                for group in std::iter::once(&mut planes.luma).chain(&mut planes.chroma) {
                    for texture in 0..group.textures.len() {
                        let bytes = group.bytes_before(self.size, texture, level);
                        group.textures[texture].truncate(bytes);
                    }
                }
            }
            Payload::Plain(plain) => plain.blocks.truncate(plain.bytes_before(level)),
        }
    }

    /// How the image is stored: the packing of luma, or the format of a plain texture and its size in
    /// texels.
    pub fn storage_name(&self) -> String {
        match &self.payload {
            Payload::Wavelet(planes) => planes.luma.packing.name().into(),
            Payload::Plain(plain) => {
                let [width, height] = plain.size;
                format!("plain {} {width} x {height}", plain.format.name())
            }
        }
    }

    /// Bytes of all blocks, which is the memory that the textures take on the GPU.
    pub fn gpu_bytes(&self) -> usize {
        let textures = self.groups().flat_map(|group| &group.textures);
        let plain = self.plain().map(|plain| &plain.blocks);
        textures.chain(plain).map(Vec::len).sum()
    }

    /// Bits per pixel of the largest level, including the padding to whole blocks.
    pub fn bits_per_pixel(&self) -> f64 {
        let level_0 = |g: &PlaneGroup| {
            layout::group_bytes(g.packing, g.codings.len(), g.plane_size(self.size, 0))
        };
        let plain = self.plain().map(|plain| plain.level_blocks(0).len());
        let bytes: usize = self.groups().map(level_0).chain(plain).sum();
        8.0 * bytes as f64 / (f64::from(self.size[0]) * f64::from(self.size[1]))
    }
}

/// The kind of data in an image, which decides its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Content {
    /// A single channel.
    Gray,
    /// Colour, stored as luma and downsampled chroma.
    Color,
    /// Colour with an alpha channel, which is stored as luma is.
    ColorAlpha,
    /// Unit normals in tangent space: X and Y are stored, Z is reconstructed.
    Normal,
}

impl Content {
    /// Number of planes in the luma group, which is the number of layers of its textures.
    pub fn luma_planes(self) -> usize {
        match self {
            Self::Gray | Self::Color => 1,
            Self::ColorAlpha | Self::Normal => 2,
        }
    }

    /// Name of the content in the tool's output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gray => "gray",
            Self::Color => "color",
            Self::ColorAlpha => "color_alpha",
            Self::Normal => "normal",
        }
    }

    /// Number of channels over which errors are measured.
    #[cfg(feature = "encode")]
    pub(super) fn error_channels(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Color | Self::Normal => 3,
            Self::ColorAlpha => 4,
        }
    }

    /// A pixel of the channels of a plain texture: RGBA, or X, Y and Z.
    pub(super) fn of_channels(self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        match self {
            Self::Gray => [r, r, r, 1.0],
            Self::Color => [r, g, b, 1.0],
            Self::ColorAlpha => [r, g, b, a],
            Self::Normal => {
                let [x, y, z] = normal_from_xy([2.0 * r - 1.0, 2.0 * g - 1.0]);
                [x, y, z, 1.0]
            }
        }
    }

    /// Returns whether the image has a chroma group.
    pub fn has_chroma(self) -> bool {
        matches!(self, Self::Color | Self::ColorAlpha)
    }
}

/// The transfer function of an image's values, which decides when they are filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorSpace {
    /// sRGB-encoded colour, which is decoded, then linearised, then filtered.
    #[default]
    Srgb,
    /// Linear data (masks, normals), which is filtered without a conversion.
    Linear,
}

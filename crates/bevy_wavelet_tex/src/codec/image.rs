//! The encoded image and its parts.

pub use super::content::{ColorSpace, Content};
use super::{
    axes::ColorAxes, layout, packing::Packing, plain::texture::PlainTexture, quantizer::PlaneCoding,
};

/// An encoded image with its mips.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveletImage {
    /// The kind of data in the image.
    pub content: Content,
    /// Transfer function of the values; alpha is always linear.
    pub color_space: ColorSpace,
    /// The axes of colour along which luma and chroma are stored; those of YCoCg without colour.
    pub axes: ColorAxes,
    /// Width and height in pixels, each in `1..=`[`layout::MAX_SIZE`].
    pub size: [u32; 2],
    /// Number of mip levels, the same in all groups; at least 1.
    pub levels: u32,
    /// The luma group (luma and alpha, gray, or X and Y of normals), then the chroma group if there
    /// is one. Empty where the image has a `plain` texture.
    pub groups: Vec<PlaneGroup>,
    /// The texture of an image that is stored without a wavelet.
    pub plain: Option<PlainTexture>,
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
}

impl WaveletImage {
    /// The blocks of one level of one layer of a texture.
    pub fn level_blocks(&self, group: usize, texture: usize, level: u32, layer: usize) -> &[u8] {
        let group = &self.groups[group];
        let format = group.packing.formats()[texture];
        let bytes = |level| format.level_bytes(group.texture_level_size(self.size, level));
        let start = group.layers() * (0..level).map(bytes).sum::<usize>() + layer * bytes(level);
        &group.textures[texture][start..start + bytes(level)]
    }

    /// Bytes of the blocks of each texture, for [`Self::truncate`].
    #[cfg(feature = "encode")]
    pub(super) fn lengths(&mut self) -> Vec<usize> {
        self.textures_mut().map(|blocks| blocks.len()).collect()
    }

    /// Removes the levels that were appended since the lengths were taken.
    #[cfg(feature = "encode")]
    pub(super) fn truncate(&mut self, lengths: &[usize]) {
        let textures = self.textures_mut().zip(lengths);
        textures.for_each(|(blocks, length)| blocks.truncate(*length));
    }

    /// Removes all levels from `level` on, to append others.
    #[cfg(feature = "encode")]
    pub(super) fn truncate_levels(&mut self, level: u32) {
        let size = self.size;
        for group in &mut self.groups {
            let formats = group.packing.formats().iter();
            let bytes = |format: &super::blocks::BlockFormat| {
                let of_level = |level| format.level_bytes(group.texture_level_size(size, level));
                group.layers() * (0..level).map(of_level).sum::<usize>()
            };
            let lengths: Vec<usize> = formats.map(bytes).collect();
            for (blocks, length) in group.textures.iter_mut().zip(lengths) {
                blocks.truncate(length);
            }
        }
        if let Some(plain) = &mut self.plain {
            let bytes = |level| plain.format.level_bytes(plain.level_size(level));
            plain.blocks.truncate((0..level).map(bytes).sum());
        }
    }

    #[cfg(feature = "encode")]
    fn textures_mut(&mut self) -> impl Iterator<Item = &mut Vec<u8>> {
        let groups = self.groups.iter_mut().flat_map(|group| &mut group.textures);
        groups.chain(self.plain.iter_mut().map(|plain| &mut plain.blocks))
    }

    /// How the image is stored: the packing of luma, or the format of a plain texture and its size in
    /// texels.
    pub fn storage_name(&self) -> String {
        match &self.plain {
            Some(plain) => {
                let [width, height] = plain.size;
                format!("plain {} {width} x {height}", plain.format.name())
            }
            None => self.groups[0].packing.name().into(),
        }
    }

    /// Bytes of all blocks, which is the memory that the textures take on the GPU.
    pub fn gpu_bytes(&self) -> usize {
        let textures = self.groups.iter().flat_map(|g| &g.textures);
        let plain = self.plain.iter().map(|plain| &plain.blocks);
        textures.chain(plain).map(Vec::len).sum()
    }

    /// Bits per pixel of the largest level, including the padding to whole blocks.
    pub fn bits_per_pixel(&self) -> f64 {
        let level_0 = |g: &PlaneGroup| {
            layout::group_bytes(g.packing, g.codings.len(), g.plane_size(self.size, 0))
        };
        let plain = self.plain.iter().map(|plain| plain.level_blocks(0).len());
        let bytes: usize = self.groups.iter().map(level_0).chain(plain).sum();
        8.0 * bytes as f64 / (f64::from(self.size[0]) * f64::from(self.size[1]))
    }
}

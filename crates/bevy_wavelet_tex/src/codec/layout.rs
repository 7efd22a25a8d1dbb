//! Sizes of planes, of the coefficient textures that hold them, and of their mip chains.
//!
//! Mip level n of a coefficient texture holds the coefficients of mip level n of its plane, down to one
//! pixel. A GPU halves sizes from level to level and rounds down. For sizes that are not powers of two that is
//! less than a plane needs (24 pixels need 12, 6, 3 and 2 coefficients, where a GPU has 12, 6, 3 and 1), so a
//! level has as much as it needs, in whole blocks.

use packing::Packing;

/// Largest width or height of an image, in pixels. The coefficient textures are half as wide and so
/// fit the 8192 texels of wgpu's default limits (luma at full size, as in colour at 5 bpp, needs an
/// adapter with twice that limit).
pub const MAX_SIZE: u32 = 16384;

/// Size of mip level `level` of an image of size `size`: halved for each level and rounded down as
/// on the GPU, at least 1.
pub fn mip_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|s| s.checked_shr(level).unwrap_or(0).max(1))
}

/// Size of a plane of an image of size `image_size`: halved `subsampling` times, rounded up.
pub fn plane_size(image_size: [u32; 2], subsampling: u32) -> [u32; 2] {
    image_size.map(|s| s.div_ceil(1 << subsampling))
}

/// Number of texels that the coefficients of a plane take in x and y: one for 2 x 2 pixels, rounded
/// up.
pub fn coefficient_size(plane_size: [u32; 2]) -> [u32; 2] {
    plane_size.map(|s| s.div_ceil(2))
}

/// Number of texels that a plane needs in x and y.
pub fn texel_size(packing: Packing, plane_size: [u32; 2]) -> [u32; 2] {
    if packing.is_wavelet() {
        coefficient_size(plane_size)
    } else {
        plane_size
    }
}

/// Size of a plane's texture in texels: whole 4 x 4 blocks, which wgpu requires of level 0.
pub fn texture_size(packing: Packing, plane_size: [u32; 2]) -> [u32; 2] {
    texel_size(packing, plane_size).map(|s| s.next_multiple_of(4))
}

/// Bytes of the largest level of a group of planes of this size, in whole blocks.
pub fn group_bytes(packing: Packing, planes: usize, plane_size: [u32; 2]) -> usize {
    let texture = texture_size(packing, plane_size);
    let formats = packing.formats().iter();
    packing.layers(planes) * formats.map(|f| f.level_bytes(texture)).sum::<usize>()
}

/// Size of a mip level of a plane's texture in texels: what a GPU makes of the largest one, or what the plane
/// needs where that is more.
pub fn texture_level_size(
    packing: Packing,
    image_size: [u32; 2],
    subsampling: u32,
    level: u32,
) -> [u32; 2] {
    let halved = mip_size(
        texture_size(packing, plane_size(image_size, subsampling)),
        level,
    );
    let needed = texel_size(
        packing,
        plane_size(mip_size(image_size, level), subsampling),
    );
    [0, 1].map(|axis| halved[axis].max(needed[axis]))
}

/// Number of mip levels of an image, the last of which is a pixel.
pub fn level_count(image_size: [u32; 2]) -> u32 {
    32 - image_size[0].max(image_size[1]).leading_zeros()
}

/// How planes are packed into block-compressed textures (thesis section 3.5.3).
pub mod packing {
    use serde::{Deserialize, Serialize};

    use crate::codec::blocks::BlockFormat;

    /// How the planes of a group are packed into textures. Files and shaders have the number of the packing.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    pub enum Packing {
        /// Wavelet at 2 bpp: the detail bands in RGB of BC3, the low band in alpha, which BC3 codes
        /// independently.
        Bc3,
        /// Wavelet at 2 bpp: HL, LH and the low band in RGB of BC7. HH is dropped (thesis section
        /// 3.5.1).
        Bc7,
        /// Wavelet at 3 bpp: the low band in BC4, the detail bands in a BC7 texture of their own.
        Split,
        /// The pixels of the plane in BC4 without a wavelet, 4 bpp.
        Bc4,
        /// The pixels of two planes in one BC1 texture without a wavelet, 4 bpp: the first plane in R
        /// and B, whose mean has one bit more than either, the second in G. The texture unit
        /// interpolates between pixels.
        Bc1,
    }

    impl Packing {
        /// All packings, in the order of their numbers.
        pub const ALL: [Self; 5] = [Self::Bc3, Self::Bc7, Self::Split, Self::Bc4, Self::Bc1];

        /// Block formats of the packing's textures.
        pub fn formats(self) -> &'static [BlockFormat] {
            match self {
                Self::Bc3 => &[BlockFormat::Bc3],
                Self::Bc7 => &[BlockFormat::Bc7],
                Self::Split => &[BlockFormat::Bc4, BlockFormat::Bc7],
                Self::Bc4 => &[BlockFormat::Bc4],
                Self::Bc1 => &[BlockFormat::Bc1],
            }
        }

        /// Returns whether a texel holds the coefficients of 2 x 2 pixels instead of one pixel.
        pub fn is_wavelet(self) -> bool {
            matches!(self, Self::Bc3 | Self::Bc7 | Self::Split)
        }

        /// Number of layers of the packing's textures for this number of planes.
        pub fn layers(self, planes: usize) -> usize {
            if self == Self::Bc1 { 1 } else { planes }
        }

        /// Bits that one layer takes for each pixel of the plane.
        pub fn bits_per_pixel(self) -> f64 {
            let bits = |f: &BlockFormat| 8.0 * f.block_bytes() as f64 / 16.0;
            let texels: f64 = if self.is_wavelet() { 0.25 } else { 1.0 };
            texels * self.formats().iter().map(bits).sum::<f64>()
        }

        /// Name of the packing in the tool's output.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_end_at_one_pixel() {
        for (size, levels) in [
            ([512, 512], 10),
            ([1000, 600], 10),
            ([1, 1], 1),
            ([MAX_SIZE, 1], 15),
        ] {
            assert_eq!(level_count(size), levels);
            assert_eq!(mip_size(size, levels - 1), [1, 1]);
        }
    }

    #[test]
    fn every_level_holds_its_coefficients_and_is_no_larger_than_the_one_before() {
        for w in 1..200 {
            for h in [1, 2, 7, 64, 100, 129] {
                for (packing, subsampling) in Packing::ALL.into_iter().zip([0, 0, 0, 1, 2]) {
                    let texture = texture_size(packing, plane_size([w, h], subsampling));
                    let mut last = texture;
                    assert!(texture.iter().all(|s| s % 4 == 0));
                    for level in 0..level_count([w, h]) {
                        let plane = plane_size(mip_size([w, h], level), subsampling);
                        let needed = texel_size(packing, plane);
                        let have = texture_level_size(packing, [w, h], subsampling, level);
                        for axis in [0, 1] {
                            assert!(needed[axis] <= have[axis] && have[axis] <= last[axis]);
                            // No more than a block more than a GPU has.
                            let halved = mip_size(texture, level)[axis].div_ceil(4);
                            assert!(have[axis].div_ceil(4) <= halved + 1);
                        }
                        last = have;
                    }
                }
            }
        }
    }
}

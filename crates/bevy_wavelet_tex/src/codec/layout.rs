//! Sizes of planes, of the coefficient textures that hold them, and of their mip chains.
//!
//! Mip level n of a coefficient texture holds the coefficients of mip level n of its plane. The GPU
//! halves the size from level to level and rounds down. For sizes that are not powers of two that
//! is too small near the end of the chain (24 pixels need 12, 6, 3 and 2 coefficients, but the GPU
//! allocates 12, 6, 3 and 1), so the chain ends before that level. One more mip can be decoded all
//! the same, since the low band of a level is the next level of its plane.

use super::packing::Packing;

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

/// Largest number of mip levels that all groups of an image can have, at least 1. `groups` are the
/// packing and the subsampling of each group.
pub fn max_level_count(image_size: [u32; 2], groups: &[(Packing, u32)]) -> u32 {
    let fits = |level: u32, (packing, subsampling): (Packing, u32)| {
        let texture = texture_size(packing, plane_size(image_size, subsampling));
        let plane = plane_size(mip_size(image_size, level), subsampling);
        let needed = texel_size(packing, plane);
        let available = mip_size(texture, level);
        let exists = texture[0].max(texture[1]) >> level > 0;
        exists && needed[0] <= available[0] && needed[1] <= available[1]
    };
    let image_levels = 32 - image_size[0].max(image_size[1]).leading_zeros();
    (0..image_levels)
        .take_while(|&level| groups.iter().all(|&group| fits(level, group)))
        .count()
        .max(1) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_of_known_sizes() {
        let luma = (Packing::Bc3, 0);
        assert_eq!(max_level_count([512, 512], &[luma]), 9); // to 2 x 2, whose low band is the last mip
        assert_eq!(max_level_count([512, 512], &[luma, (Packing::Bc3, 1)]), 8);
        assert_eq!(max_level_count([512, 512], &[luma, (Packing::Bc1, 1)]), 9);
        assert_eq!(max_level_count([512, 512], &[luma, (Packing::Bc1, 2)]), 8);
        assert_eq!(max_level_count([768, 512], &[luma]), 8);
        assert_eq!(max_level_count([24, 24], &[luma]), 3);
        assert_eq!(max_level_count([1, 1], &[luma, (Packing::Bc1, 2)]), 1);
        assert_eq!(max_level_count([MAX_SIZE, 1], &[luma]), 14);
    }

    #[test]
    fn every_level_holds_its_coefficients() {
        for w in 1..200 {
            for h in [1, 2, 7, 64, 100, 129] {
                for (packing, subsampling) in Packing::ALL.into_iter().zip([0, 0, 0, 1, 2]) {
                    let texture = texture_size(packing, plane_size([w, h], subsampling));
                    assert!(texture.iter().all(|s| s % 4 == 0));
                    for level in 0..max_level_count([w, h], &[(packing, subsampling)]) {
                        let plane = plane_size(mip_size([w, h], level), subsampling);
                        let needed = texel_size(packing, plane);
                        let have = mip_size(texture, level);
                        assert!(needed[0] <= have[0] && needed[1] <= have[1]);
                    }
                }
            }
        }
    }
}

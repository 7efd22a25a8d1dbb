//! The placement of the mip levels of a texture.
//!
//! The texture unit gathers texels from the first level of a texture only (WGSL's `textureGather`
//! as well as the APIs below it), and a lookup needs 4 x 4 values of the low band from any level. So
//! all levels lie in one: level 1 beside level 0, or below it where that takes less memory, and the
//! others after level 1, in whole 4 x 4 blocks. A square texture takes 3/2 of the memory of its level
//! 0 instead of the 4/3 of a mip chain.
//!
//! A shader computes where a level lies: with `b` the blocks that all but level 0 have along their
//! axis, level n begins after `stack - (2 stack >> n)` of them, which for powers of two is exactly the
//! sum of those before it.

use crate::codec::image::{PlaneGroup, WaveletImage};

/// Where the levels of a group of planes lie in its textures. All lengths are in texels, apart from
/// `stack`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MipAtlas {
    /// Size of the textures.
    pub(crate) size: [u32; 2],
    /// Position of level 1.
    pub(crate) second: [u32; 2],
    /// The step from a block to the next along the axis in which levels follow level 1.
    pub(crate) block: [u32; 2],
    /// Level n begins `stack - (2 stack >> n)` blocks after level 1.
    pub(crate) stack: u32,
    /// Levels after this one are one more block further each: they are smaller than a block.
    pub(crate) tail: u32,
}

impl MipAtlas {
    /// `level_size` is that of each level in texels.
    pub(crate) fn new(levels: u32, level_size: impl Fn(u32) -> [u32; 2]) -> Self {
        let blocks = |level| level_size(level).map(|s| s.div_ceil(4));
        let [beside, below] = [1, 0].map(|axis| Self::along(levels, &blocks, axis));
        let area = |atlas: &Self| u64::from(atlas.size[0]) * u64::from(atlas.size[1]);
        if area(&below) < area(&beside) {
            below
        } else {
            beside
        }
    }

    /// That of a group of planes.
    pub(crate) fn of(image: &WaveletImage, group: &PlaneGroup) -> Self {
        Self::new(image.levels, |level| {
            group.texture_level_size(image.size, level)
        })
    }

    /// With levels of these whole blocks after level 1 along an axis.
    fn along(levels: u32, blocks: &impl Fn(u32) -> [u32; 2], axis: usize) -> Self {
        let size = blocks(0).map(|blocks| 4 * blocks);
        if levels == 1 {
            return Self {
                size,
                second: [0; 2],
                block: [0; 2],
                stack: 0,
                tail: 0,
            };
        }
        let across = 1 - axis;
        let needed = |level: u32| blocks(level)[axis];
        let fits = |stack: &u32| {
            let tail = tail(*stack);
            (1..levels.min(tail)).all(|n| (stack >> (n - 1)) - (stack >> n) >= needed(n))
        };
        let most = needed(0).next_power_of_two();
        let stack = (needed(0)..most).find(fits).unwrap_or(most);
        let mut second = [0; 2];
        second[across] = size[across];
        let mut block = [0; 2];
        block[axis] = 4;
        let mut atlas = Self {
            size,
            second,
            block,
            stack,
            tail: tail(stack),
        };
        let last = levels - 1;
        let end = atlas.origin(last)[axis] + 4 * needed(last);
        atlas.size[axis] = size[axis].max(end);
        atlas.size[across] += 4 * blocks(1)[across];
        atlas
    }

    /// Position of a level.
    pub(crate) fn origin(&self, level: u32) -> [u32; 2] {
        if level == 0 {
            return [0; 2];
        }
        let blocks = self.stack - ((2 * self.stack) >> level) + level.saturating_sub(self.tail);
        [0, 1].map(|axis| self.second[axis] + self.block[axis] * blocks)
    }

    /// The blocks of a texture of a group, layer by layer.
    pub(super) fn arranged(
        &self,
        image: &WaveletImage,
        group: &PlaneGroup,
        texture: usize,
    ) -> Vec<u8> {
        let bytes = group.packing.formats()[texture].block_bytes();
        let row = self.size[0] as usize / 4 * bytes;
        let layer_bytes = row * self.size[1] as usize / 4;
        let mut arranged = vec![0; layer_bytes * group.layers()];
        for (layer, out) in arranged.chunks_exact_mut(layer_bytes).enumerate() {
            for level in 0..image.levels {
                let origin = self.origin(level).map(|texel| texel as usize / 4);
                let size = group.texture_level_size(image.size, level);
                let width = size[0].div_ceil(4) as usize * bytes;
                let rows = group.level_blocks(image.size, texture, level, layer);
                for (y, blocks) in rows.chunks_exact(width).enumerate() {
                    let start = (origin[1] + y) * row + origin[0] * bytes;
                    out[start..start + width].copy_from_slice(blocks);
                }
            }
        }
        arranged
    }
}

/// The first level that has no block of its own between `stack - (2 stack >> n)` and the next.
fn tail(stack: u32) -> u32 {
    33 - stack.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::{
        layout::{level_count, texture_level_size},
        packing::Packing,
    };

    #[test]
    fn no_level_lies_on_another_or_outside() {
        let sizes = (1..400u32).chain([512, 1000, 2048, 8192]);
        for (width, (packing, subsampling)) in sizes.flat_map(|width| {
            Packing::ALL
                .into_iter()
                .zip([0, 0, 0, 0, 2])
                .map(move |p| (width, p))
        }) {
            for height in [1u32, 8, 12, 37, 64, 100, 256, 600, 1024] {
                let size = [width, height];
                let texels = |level| texture_level_size(packing, size, subsampling, level);
                let most = level_count(size);
                for levels in [1, 2, most / 2, most].into_iter().filter(|l| *l > 0) {
                    let atlas = MipAtlas::new(levels, texels);
                    let boxes: Vec<_> = (0..levels)
                        .map(|level| {
                            (
                                atlas.origin(level),
                                texels(level).map(|s| s.next_multiple_of(4)),
                            )
                        })
                        .collect();
                    for (i, (a, a_size)) in boxes.iter().enumerate() {
                        let within = |axis: usize| a[axis] + a_size[axis] <= atlas.size[axis];
                        assert!(
                            within(0) && within(1),
                            "{size:?}, {levels}: {i} in {atlas:?}"
                        );
                        assert!(a.iter().all(|texel| texel % 4 == 0));
                        for (b, b_size) in &boxes[..i] {
                            let apart = |axis: usize| {
                                a[axis] >= b[axis] + b_size[axis]
                                    || b[axis] >= a[axis] + a_size[axis]
                            };
                            assert!(apart(0) || apart(1), "{size:?}, {levels}: {i} in {atlas:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn squares_take_half_as_much_again_as_level_0() {
        let size = |size: [u32; 2]| move |level: u32| size.map(|side: u32| (side >> level).max(1));
        let atlas = MipAtlas::new(9, size([256, 256]));
        assert_eq!(atlas.size, [384, 260]);
        // Strips of levels that are a block high lie below.
        assert_eq!(MipAtlas::new(7, size([256, 4])).size, [256, 8]);
    }
}

//! Files without their largest mip levels.
//!
//! A level of a texture has what a GPU makes of the largest one, or what its plane needs. So where another level
//! becomes the largest, those after it can have a row or a column of blocks more or less than before, which are padding.

use crate::codec::{
    blocks::BlockFormat,
    image::PlaneGroup,
    layout::{self, mip_size},
    plain::PlainTexture,
};

/// The first level whose sides are at most `max_size` pixels, or the last level.
pub(super) fn first_level(size: [u32; 2], levels: u32, max_size: Option<u32>) -> u32 {
    let Some(most) = max_size else { return 0 };
    let fits = |level: &u32| mip_size(size, *level).iter().all(|side| *side <= most);
    (0..levels).find(fits).unwrap_or(levels - 1)
}

/// The level of a plain texture from which on it can do without those before, at most `first`: a texture has whole
/// blocks, and one that is smaller than its image has to keep the ratio.
pub(super) fn first_of_plain(texture: &PlainTexture, image_size: [u32; 2], first: u32) -> u32 {
    if !texture.is_scaled(image_size) {
        return first;
    }
    let is_whole = |level: &u32| texture.level_size(*level).iter().all(|side| side % 4 == 0);
    (0..=first).rfind(is_whole).unwrap_or(0)
}

/// Lays out the blocks of a group, which has the levels from `first` to `levels` of an image of this size, as those
/// of an image of its own.
pub(super) fn begin_group(group: &mut PlaneGroup, size: [u32; 2], first: u32, levels: u32) {
    let smaller = mip_size(size, first);
    let shape = |level| Level {
        before: group.texture_level_size(size, level),
        after: group.texture_level_size(smaller, level - first),
    };
    let shapes: Vec<Level> = (first..levels).map(shape).collect();
    let layers = group.layers();
    let formats = group.packing.formats();
    for (blocks, format) in group.textures.iter_mut().zip(formats) {
        *blocks = begun(blocks, *format, layers, &shapes);
    }
}

/// The same of a plain texture.
pub(super) fn begin_plain(texture: &mut PlainTexture, size: [u32; 2], first: u32, levels: u32) {
    let largest = if texture.is_scaled(size) {
        texture.level_size(first)
    } else {
        PlainTexture::full_size(mip_size(size, first))
    };
    let shape = |level| Level {
        before: texture.level_size(level),
        after: layout::mip_size(largest, level - first),
    };
    let shapes: Vec<Level> = (first..levels).map(shape).collect();
    texture.blocks = begun(&texture.blocks, texture.format, 1, &shapes);
    texture.size = largest;
}

/// The size of a level in texels, before and after.
struct Level {
    before: [u32; 2],
    after: [u32; 2],
}

fn begun(blocks: &[u8], format: BlockFormat, layers: usize, levels: &[Level]) -> Vec<u8> {
    let bytes = format.block_bytes();
    let mut rest = blocks;
    let mut all = Vec::with_capacity(blocks.len());
    for level in levels {
        let [before, after] =
            [level.before, level.after].map(|size| size.map(|s| s.div_ceil(4) as usize));
        for _ in 0..layers {
            let (layer, next) = rest.split_at(format.level_bytes(level.before));
            rest = next;
            let start = all.len();
            all.resize(start + format.level_bytes(level.after), 0);
            let rows = layer.chunks_exact(before[0] * bytes);
            let row_bytes = before[0].min(after[0]) * bytes;
            for (from, to) in rows.zip(all[start..].chunks_exact_mut(after[0] * bytes)) {
                to[..row_bytes].copy_from_slice(&from[..row_bytes]);
            }
        }
    }
    all
}

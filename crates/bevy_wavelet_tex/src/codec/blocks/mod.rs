//! BC blocks: 4 x 4 texels in 8 or 16 bytes.
//!
//! This file decodes BC1, BC3, BC4, BC5 and BC7 blocks to texels.
//!
//! | file | contents |
//! | --- | --- |
//! | `encode` | encodes BC1 and BC3 by `fit`, BC4 and BC3 with `dds`, and BC7 with `ctt-bc7enc-rdo` (bc7e) |
//! | `fit` | the search for endpoints by the error in pixels |
//! | `interpolated` | refines BC1 blocks by the error of the pixels between their texels |
//!
//! BC1 and the colour half of BC3 have an encoder of their own because no library minimises the
//! error that matters here: that of the coefficients after the power curve is inverted, with two
//! channels that stand for one value.

#[cfg(feature = "encode")]
mod encode;
#[cfg(feature = "encode")]
mod fit;
#[cfg(feature = "encode")]
mod interpolated;

use rayon::prelude::*;

#[cfg(feature = "encode")]
pub use encode::{
    BlockQuality, ChromaEncoder, ColorEncoder, DetailEncoder, encode_bc1, encode_bc3, encode_bc4,
    encode_bc7, encode_bc7_rgba, with_alpha_blocks,
};
#[cfg(feature = "encode")]
pub(super) use encode::{is_dark, map_blocks};
#[cfg(feature = "encode")]
pub use fit::Starts;

/// An RGBA texel, 8 bits a channel.
pub type Texel = [u8; 4];

/// A block format. Files have the number of that of a plain texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BlockFormat {
    /// RGB, 8 bytes.
    Bc1,
    /// RGB as in BC1 and alpha as in BC4, 16 bytes.
    Bc3,
    /// One channel, 8 bytes.
    Bc4,
    /// Two channels as in BC4, 16 bytes.
    Bc5,
    /// RGBA, 16 bytes.
    Bc7,
}

impl BlockFormat {
    /// All formats, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Bc1, Self::Bc3, Self::Bc4, Self::Bc5, Self::Bc7];

    /// Name of the format in the tool's output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bc1 => "bc1",
            Self::Bc3 => "bc3",
            Self::Bc4 => "bc4",
            Self::Bc5 => "bc5",
            Self::Bc7 => "bc7",
        }
    }

    /// Bytes of one block.
    pub fn block_bytes(self) -> usize {
        match self {
            Self::Bc1 | Self::Bc4 => 8,
            Self::Bc3 | Self::Bc5 | Self::Bc7 => 16,
        }
    }

    /// Bytes of one level of one layer of `size` texels.
    pub fn level_bytes(self, size: [u32; 2]) -> usize {
        let blocks = size.map(|s| s.div_ceil(4) as usize);
        blocks[0] * blocks[1] * self.block_bytes()
    }
}

/// Decodes one level of `size` texels. Partial blocks at the right and bottom are cropped.
///
/// The decoder is exact: interpolated values are real numbers in `[0, 1]`. GPUs, and libraries that
/// decode to bytes, round those of BC1, BC3, BC4 and BC5 in different ways, by one or two 8-bit steps;
/// BC7 is defined in whole bytes. BC4 decodes to red, BC5 to red
/// and green. Missing channels are 0, and missing alpha is
/// 1.
///
/// # Panics
/// Panics when `blocks` is shorter than [`BlockFormat::level_bytes`] of `size`.
pub fn decode_blocks(format: BlockFormat, blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
    match format {
        BlockFormat::Bc1 => decode_texels::<8>(blocks, size, |block, i| {
            let [r, g, b] = color_texel(u64::from_le_bytes(block), i, true);
            [r, g, b, 1.0]
        }),
        BlockFormat::Bc3 => decode_texels::<16>(blocks, size, |block, i| {
            let block = u128::from_le_bytes(block);
            let [r, g, b] = color_texel((block >> 64) as u64, i, false);
            [r, g, b, single_texel(block as u64, i)]
        }),
        BlockFormat::Bc4 => decode_texels::<8>(blocks, size, |block, i| {
            [single_texel(u64::from_le_bytes(block), i), 0.0, 0.0, 1.0]
        }),
        BlockFormat::Bc5 => decode_texels::<16>(blocks, size, |block, i| {
            let block = u128::from_le_bytes(block);
            let channels = [block as u64, (block >> 64) as u64];
            let [r, g] = channels.map(|block| single_texel(block, i));
            [r, g, 0.0, 1.0]
        }),
        BlockFormat::Bc7 => decode_bc7(blocks, size),
    }
}

/// Decodes as [`decode_blocks`] does with [`BlockFormat::Bc3`].
///
/// # Panics
/// Panics as [`decode_blocks`] does.
pub fn decode_bc3(blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
    decode_blocks(BlockFormat::Bc3, blocks, size)
}

/// Decodes all texels of a level. `texel` decodes the texel of a block with the given index, row by
/// row.
fn decode_texels<const BYTES: usize>(
    blocks: &[u8],
    size: [u32; 2],
    texel: impl Fn([u8; BYTES], u32) -> [f32; 4] + Sync,
) -> Vec<[f32; 4]> {
    let [width, height] = size.map(|s| s as usize);
    let blocks_per_row = width.div_ceil(4);
    let (blocks, _) = blocks.as_chunks::<BYTES>();
    let mut texels = vec![[0.0; 4]; width * height];
    let rows = texels.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        let blocks = &blocks[y / 4 * blocks_per_row..];
        for (x, decoded) in row.iter_mut().enumerate() {
            *decoded = texel(blocks[x / 4], (y % 4 * 4 + x % 4) as u32);
        }
    });
    texels
}

fn bits(block: u64, start: u32, count: u32) -> u32 {
    (block >> start) as u32 & ((1 << count) - 1)
}

fn unorm(block: u64, start: u32, count: u32) -> f32 {
    bits(block, start, count) as f32 / ((1 << count) - 1) as f32
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Decodes a texel of a colour block. From the lowest bit it has two 5:6:5 colours and sixteen
/// 2-bit indices (thesis Fig. 3.12). Where the first colour is not larger than the second, BC1 has
/// a mode of three colours and black; BC3 does not.
fn color_texel(block: u64, i: u32, is_bc1: bool) -> [f32; 3] {
    let index = bits(block, 32 + 2 * i, 2);
    let t = if is_bc1 && bits(block, 0, 16) <= bits(block, 16, 16) {
        match index {
            3 => return [0.0; 3],
            _ => [0.0, 1.0, 0.5][index as usize],
        }
    } else {
        [0.0, 1.0, 1.0 / 3.0, 2.0 / 3.0][index as usize]
    };
    [(11, 5), (5, 6), (0, 5)].map(|(at, n)| mix(unorm(block, at, n), unorm(block, 16 + at, n), t))
}

/// Decodes a texel of a single-channel block. From the lowest bit it has two 8-bit endpoints and
/// sixteen 3-bit indices (thesis Fig. 3.14).
fn single_texel(block: u64, i: u32) -> f32 {
    let (a0, a1) = (unorm(block, 0, 8), unorm(block, 8, 8));
    match (
        bits(block, 16 + 3 * i, 3),
        bits(block, 0, 8) > bits(block, 8, 8),
    ) {
        (0, _) => a0,
        (1, _) => a1,
        (index, true) => mix(a0, a1, (index - 1) as f32 / 7.0),
        (6, false) => 0.0,
        (7, false) => 1.0,
        (index, false) => mix(a0, a1, (index - 1) as f32 / 5.0),
    }
}

fn decode_bc7(blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
    let [width, height] = size.map(|s| s as usize);
    let blocks_per_row = width.div_ceil(4);
    let (blocks, _) = blocks.as_chunks::<16>();
    let mut texels = vec![[0.0; 4]; width * height];
    let strips = texels.par_chunks_mut(4 * width).enumerate();
    strips.for_each(|(strip, texels)| {
        let blocks = &blocks[strip * blocks_per_row..][..blocks_per_row];
        for (left, block) in blocks.iter().enumerate() {
            let mut bytes = [0u8; 64];
            bcdec_rs::bc7(block, &mut bytes, 16);
            for (row, bytes) in texels.chunks_mut(width).zip(bytes.as_chunks::<16>().0) {
                let decoded = bytes.as_chunks::<4>().0;
                for (texel, decoded) in row[4 * left..].iter_mut().zip(decoded) {
                    *texel = decoded.map(|v| f32::from(v) / 255.0);
                }
            }
        }
    });
    texels
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Decoder = fn(&[u8], &mut [u8], usize);

    fn check(format: BlockFormat, block: &[u8], library: &[u8]) -> Result<(), TestCaseError> {
        let ours = decode_blocks(format, block, [4, 4]);
        for (ours, library) in ours.iter().zip(library.as_chunks::<4>().0) {
            for (ours, library) in ours.iter().zip(library) {
                prop_assert!(
                    (ours * 255.0 - f32::from(*library)).abs() <= 1.0,
                    "{ours} {library}"
                );
            }
        }
        Ok(())
    }

    proptest! {
        /// The decoder agrees with an independent one, which rounds to bytes.
        #[test]
        fn every_block_decodes_as_the_library_does(block in any::<[u8; 16]>()) {
            for (format, decode) in [
                (BlockFormat::Bc3, bcdec_rs::bc3 as Decoder),
                (BlockFormat::Bc7, bcdec_rs::bc7),
            ] {
                let mut library = [0; 64];
                decode(&block, &mut library, 16);
                check(format, &block, &library)?;
            }
            let half = &block[..8];
            let mut library = [0; 64];
            bcdec_rs::bc1(half, &mut library, 16);
            // The library's alpha is 0 where BC1's black is transparent; nothing here reads it.
            library.iter_mut().skip(3).step_by(4).for_each(|a| *a = 255);
            check(BlockFormat::Bc1, half, &library)?;
            let mut single = [0; 16];
            bcdec_rs::bc4(half, &mut single, 4, false);
            check(BlockFormat::Bc4, half, &single.map(|v| [v, 0, 0, 255]).concat())?;
            let mut pairs = [0; 32];
            bcdec_rs::bc5(&block, &mut pairs, 8, false);
            let (pairs, _) = pairs.as_chunks::<2>();
            let texels: Vec<u8> = pairs.iter().flat_map(|[r, g]| [*r, *g, 0, 255]).collect();
            check(BlockFormat::Bc5, &block, &texels)?;
        }
    }

    #[test]
    fn partial_blocks_are_cut() {
        for format in BlockFormat::ALL {
            let blocks: Vec<u8> = (0..format.level_bytes([9, 6]))
                .map(|i| i as u8 * 37)
                .collect();
            let whole = decode_blocks(format, &blocks, [12, 8]);
            let cut = decode_blocks(format, &blocks, [9, 6]);
            assert_eq!(cut.len(), 54);
            for (i, texel) in cut.iter().enumerate() {
                assert_eq!(*texel, whole[i / 9 * 12 + i % 9], "{format:?}");
            }
        }
    }
}

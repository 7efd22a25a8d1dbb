//! BC3 blocks to texels and back: 4 x 4 RGBA texels in 16 bytes.

/// Bytes of one BC3 block.
pub const BC3_BLOCK_BYTES: usize = 16;

/// An RGBA texel, 8 bits a channel.
pub type Texel = [u8; 4];

/// Decodes one BC3 level of `size` texels; partial blocks at the right and bottom are cut.
///
/// Exact: the interpolated values are real numbers in `[0, 1]`. GPUs, and the libraries that
/// decode to bytes, round them each in their own way, by one or two 8-bit steps.
///
/// # Panics
/// When `blocks` is shorter than [`super::layout::level_bytes`] of `size`.
pub fn decode_bc3(blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
    let [width, height] = size.map(|s| s as usize);
    let blocks_per_row = width.div_ceil(4);
    let mut texels = vec![[0.0; 4]; width * height];
    let (blocks, _) = blocks.as_chunks::<BC3_BLOCK_BYTES>();
    for y in 0..height {
        for x in 0..width {
            let block = u128::from_le_bytes(blocks[y / 4 * blocks_per_row + x / 4]);
            texels[y * width + x] = decode_texel(block, (y % 4 * 4 + x % 4) as u32);
        }
    }
    texels
}

/// Texel `i` of a block, row by row. From the lowest bit: two 8-bit end points of alpha, sixteen
/// 3-bit indices; two 5:6:5 colours, sixteen 2-bit indices (thesis Fig. 3.14).
fn decode_texel(block: u128, i: u32) -> [f32; 4] {
    let bits = |start: u32, count: u32| (block >> start) as u32 & ((1 << count) - 1);
    let unorm = |start, count| bits(start, count) as f32 / ((1 << count) - 1) as f32;
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;

    let (a0, a1) = (unorm(0, 8), unorm(8, 8));
    let a = match (bits(16 + 3 * i, 3), bits(0, 8) > bits(8, 8)) {
        (0, _) => a0,
        (1, _) => a1,
        (index, true) => mix(a0, a1, (index - 1) as f32 / 7.0),
        (6, false) => 0.0,
        (7, false) => 1.0,
        (index, false) => mix(a0, a1, (index - 1) as f32 / 5.0),
    };
    let t = [0.0, 1.0, 1.0 / 3.0, 2.0 / 3.0][bits(96 + 2 * i, 2) as usize];
    let [r, g, b] =
        [(11, 5), (5, 6), (0, 5)].map(|(at, n)| mix(unorm(64 + at, n), unorm(80 + at, n), t));
    [r, g, b, a]
}

/// How hard the block encoder tries.
#[cfg(feature = "encode")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockQuality {
    /// To compare parameters.
    Normal,
    /// To keep.
    High,
}

/// Encodes one level of `size` texels as BC3; partial blocks are filled by repeating the edge.
///
/// # Panics
/// When `texels` is not `size` texels.
#[cfg(feature = "encode")]
pub fn encode_bc3(texels: &[Texel], size: [u32; 2], quality: BlockQuality) -> Vec<u8> {
    let mut options = dds::EncodeOptions::default();
    options.quality = match quality {
        BlockQuality::Normal => dds::CompressionQuality::Normal,
        BlockQuality::High => dds::CompressionQuality::High,
    };
    let size_texels = dds::Size::new(size[0], size[1]);
    let view = dds::ImageView::new(
        texels.as_flattened(),
        size_texels,
        dds::ColorFormat::RGBA_U8,
    )
    .expect("as many texels as the size says");
    let mut blocks = Vec::with_capacity(super::layout::level_bytes(size));
    dds::encode(&mut blocks, view, dds::Format::BC3_UNORM, None, &options)
        .expect("BC3 of an image in memory cannot fail");
    blocks
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bytes(texels: Vec<[f32; 4]>) -> Vec<Texel> {
        texels
            .into_iter()
            .map(|t| t.map(|v| (v * 255.0).round() as u8))
            .collect()
    }

    proptest! {
        /// An independent decoder, which rounds to bytes.
        #[test]
        fn every_block_decodes_as_the_library_does(block in any::<[u8; BC3_BLOCK_BYTES]>()) {
            let mut library = [0; 64];
            bcdec_rs::bc3(&block, &mut library, 16);
            let ours = decode_bc3(&block, [4, 4]);
            for (ours, library) in ours.as_flattened().iter().zip(library) {
                prop_assert!((ours * 255.0 - f32::from(library)).abs() <= 1.0, "{ours} {library}");
            }
        }
    }

    #[test]
    fn constant_blocks_and_alpha_ramps_come_back() {
        // 5:6:5 holds 0 and 255 exactly; alpha has 8 bits at its end points.
        let size = [6, 5];
        let texels: Vec<Texel> = (0..30).map(|_| [255, 0, 255, 77]).collect();
        assert_eq!(
            bytes(decode_bc3(
                &encode_bc3(&texels, size, BlockQuality::High),
                size
            )),
            texels
        );

        let ramp: Vec<Texel> = (0..16).map(|i| [0, 0, 0, 100 + 7 * (i % 8)]).collect();
        let back = bytes(decode_bc3(
            &encode_bc3(&ramp, [4, 4], BlockQuality::High),
            [4, 4],
        ));
        for (a, b) in ramp.iter().zip(back) {
            assert!(a[3].abs_diff(b[3]) <= 1);
        }
    }
}

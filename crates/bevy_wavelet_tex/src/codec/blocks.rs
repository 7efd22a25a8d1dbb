//! BC3 blocks to texels and back: 4 x 4 RGBA texels in 16 bytes.

/// Bytes of one BC3 block.
pub const BC3_BLOCK_BYTES: usize = 16;

/// An RGBA texel, 8 bits a channel.
pub type Texel = [u8; 4];

/// Decodes one BC3 level of `size` texels; partial blocks at the right and bottom are cut.
///
/// # Panics
/// When `blocks` is shorter than [`super::layout::level_bytes`] of `size`.
pub fn decode_bc3(blocks: &[u8], size: [u32; 2]) -> Vec<Texel> {
    let [width, height] = size.map(|s| s as usize);
    let blocks_per_row = width.div_ceil(4);
    let mut texels = vec![[0; 4]; width * height];
    let mut block_texels = [0; 64];
    for (i, block) in blocks.chunks_exact(BC3_BLOCK_BYTES).enumerate() {
        let (left, top) = (i % blocks_per_row * 4, i / blocks_per_row * 4);
        bcdec_rs::bc3(block, &mut block_texels, 16);
        for y in top..height.min(top + 4) {
            for x in left..width.min(left + 4) {
                let at = (y - top) * 16 + (x - left) * 4;
                texels[y * width + x].copy_from_slice(&block_texels[at..at + 4]);
            }
        }
    }
    texels
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

    #[test]
    fn constant_blocks_and_alpha_ramps_come_back() {
        // 5:6:5 holds 0 and 255 exactly; alpha has 8 bits at its end points.
        let size = [6, 5];
        let texels: Vec<Texel> = (0..30).map(|_| [255, 0, 255, 77]).collect();
        assert_eq!(
            decode_bc3(&encode_bc3(&texels, size, BlockQuality::High), size),
            texels
        );

        let ramp: Vec<Texel> = (0..16).map(|i| [0, 0, 0, 100 + 7 * (i % 8)]).collect();
        let back = decode_bc3(&encode_bc3(&ramp, [4, 4], BlockQuality::High), [4, 4]);
        for (a, b) in ramp.iter().zip(back) {
            assert!(a[3].abs_diff(b[3]) <= 1);
        }
    }
}

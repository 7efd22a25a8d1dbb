//! Block encoders of other crates behind one interface.

use rayon::prelude::*;

use super::Texel;

/// The encoding time that a block encoder spends on quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockQuality {
    /// Fast enough to compare parameters.
    Normal,
    /// For blocks that are written to a file.
    High,
}

/// Encodes one level of `size` texels as BC3. Partial blocks are filled by repeating the edge.
///
/// # Panics
/// Panics when `texels` does not have `size` texels.
pub fn encode_bc3(texels: &[Texel], size: [u32; 2], quality: BlockQuality) -> Vec<u8> {
    let color = dds::ColorFormat::RGBA_U8;
    with_dds(
        texels.as_flattened(),
        size,
        color,
        dds::Format::BC3_UNORM,
        quality,
    )
}

/// Encodes the same as opaque BC1, a baseline for wavelet textures.
///
/// # Panics
/// Panics when `texels` does not have `size` texels.
pub fn encode_bc1(texels: &[Texel], size: [u32; 2], quality: BlockQuality) -> Vec<u8> {
    let color = dds::ColorFormat::RGBA_U8;
    with_dds(
        texels.as_flattened(),
        size,
        color,
        dds::Format::BC1_UNORM,
        quality,
    )
}

/// Encodes values in `[0, 1]` as BC4.
///
/// # Panics
/// Panics when `values` does not have `size` values.
pub fn encode_bc4(values: &[f32], size: [u32; 2], quality: BlockQuality) -> Vec<u8> {
    let bytes: Vec<[u8; 4]> = values.iter().map(|v| v.to_ne_bytes()).collect();
    let color = dds::ColorFormat::GRAYSCALE_F32;
    with_dds(
        bytes.as_flattened(),
        size,
        color,
        dds::Format::BC4_UNORM,
        quality,
    )
}

fn with_dds(
    bytes: &[u8],
    [width, height]: [u32; 2],
    color: dds::ColorFormat,
    format: dds::Format,
    quality: BlockQuality,
) -> Vec<u8> {
    let mut options = dds::EncodeOptions::default();
    options.quality = match quality {
        BlockQuality::Normal => dds::CompressionQuality::Normal,
        BlockQuality::High => dds::CompressionQuality::High,
    };
    let view = dds::ImageView::new(bytes, dds::Size::new(width, height), color)
        .expect("as many texels as the size says");
    let mut blocks = Vec::new();
    dds::encode(&mut blocks, view, format, None, &options).expect("an image in memory cannot fail");
    blocks
}

/// Number of blocks per call of bc7e: enough to make the cost of the call itself negligible.
const BC7_BATCH: usize = 64;

/// Encodes `size` texels as opaque BC7, with weights of the squared errors of R, G and B. Partial
/// blocks are filled by repeating the edge. `texel` returns R, G and B at a position, in `[0, 1]`.
///
/// bc7e itself uses one thread. The result does not depend on the number of threads that call it.
pub fn encode_bc7(
    size: [u32; 2],
    weights: [u32; 3],
    texel: impl Fn(u32, u32) -> [f32; 3] + Sync,
) -> Vec<u8> {
    let [r, g, b] = weights;
    encode_bc7_rgba(size, [r, g, b, 1], |x, y| {
        let [r, g, b] = texel(x, y);
        [r, g, b, 1.0]
    })
}

/// Encodes the same with alpha.
pub fn encode_bc7_rgba(
    size: [u32; 2],
    weights: [u32; 4],
    texel: impl Fn(u32, u32) -> [f32; 4] + Sync,
) -> Vec<u8> {
    let mut params = ctt_bc7enc_rdo::params_init_slow(false);
    params.m_weights = weights;
    let [columns, rows] = size.map(|s| s.div_ceil(4));
    let count = columns as usize * rows as usize;
    let mut words = vec![0u64; 2 * count];
    words
        .par_chunks_mut(2 * BC7_BATCH)
        .enumerate()
        .for_each(|(batch, words)| {
            let first = batch * BC7_BATCH;
            let blocks = first as u32..first as u32 + words.len() as u32 / 2;
            let pixels: Vec<u32> = blocks
                .flat_map(|block| (0..16).map(move |i| (block, i)))
                .map(|(block, i)| {
                    let x = (block % columns * 4 + i % 4).min(size[0] - 1);
                    let y = (block / columns * 4 + i / 4).min(size[1] - 1);
                    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                    u32::from_le_bytes(texel(x, y).map(byte))
                })
                .collect();
            ctt_bc7enc_rdo::compress_blocks(words, &pixels, &params);
        });
    let bytes: Vec<[u8; 8]> = words.into_iter().map(u64::to_le_bytes).collect();
    bytes.into_flattened()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::blocks::{BlockFormat, decode_bc3, decode_blocks};

    fn bytes(texels: Vec<[f32; 4]>) -> Vec<Texel> {
        texels
            .into_iter()
            .map(|t| t.map(|v| (v * 255.0).round() as u8))
            .collect()
    }

    #[test]
    fn constant_blocks_and_alpha_ramps_come_back() {
        // 5:6:5 stores 0 and 255 exactly; alpha has 8 bits at its endpoints.
        let size = [6, 5];
        let texels: Vec<Texel> = (0..30).map(|_| [255, 0, 255, 77]).collect();
        let blocks = encode_bc3(&texels, size, BlockQuality::High);
        assert_eq!(bytes(decode_bc3(&blocks, size)), texels);

        let ramp: Vec<Texel> = (0..16).map(|i| [0, 0, 0, 100 + 7 * (i % 8)]).collect();
        let blocks = encode_bc3(&ramp, [4, 4], BlockQuality::High);
        for (a, b) in ramp.iter().zip(bytes(decode_bc3(&blocks, [4, 4]))) {
            assert!(a[3].abs_diff(b[3]) <= 1);
        }
    }

    #[test]
    fn bc7_keeps_a_gradient_within_two_steps_at_any_size() {
        for size in [[1, 1], [6, 5], [37, 70]] {
            let value = |x: u32, y: u32| [x as f32 / 80.0, 0.5, y as f32 / 80.0];
            let blocks = encode_bc7(size, [1, 1, 1], value);
            let texels = decode_blocks(BlockFormat::Bc7, &blocks, size);
            for (i, texel) in texels.iter().enumerate() {
                let expected = value(i as u32 % size[0], i as u32 / size[0]);
                for c in 0..3 {
                    assert!(
                        (texel[c] - expected[c]).abs() <= 2.0 / 255.0,
                        "{size:?} {i}"
                    );
                }
            }
        }
    }
}

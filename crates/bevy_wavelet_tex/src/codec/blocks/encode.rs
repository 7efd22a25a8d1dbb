//! Encoders of blocks: of this crate for BC1 and the colour half of BC3, and of other crates.

use rayon::prelude::*;

use super::{
    BlockFormat, Texel, decode_blocks,
    fit::{Channel, Starts, Target, fit, positions},
    interpolated::{Interpolated, Line},
};
use crate::codec::{haar::Details, interpolation::NormalEquations, quantizer::PlaneCoding};

/// Makes the blocks of a texture of `size` texels of the positions of the texels in each. Those of partial blocks are
/// outside of the texture.
pub(in crate::codec) fn map_blocks<T: Send>(
    size: [u32; 2],
    block: impl Fn([(u32, u32); 16]) -> T + Sync,
) -> Vec<T> {
    let [columns, rows] = size.map(|s| s.div_ceil(4));
    let positions = |block: u32| {
        let [left, top] = [block % columns, block / columns].map(|block| 4 * block);
        std::array::from_fn(|i| (left + i as u32 % 4, top + i as u32 / 4))
    };
    let blocks = (0..columns * rows).into_par_iter();
    blocks.map(|number| block(positions(number))).collect()
}

/// The line of a block that approximates a target, and its squared error, of which more than `most` is of no use.
fn fitted<const C: usize>(
    channels: &[Channel; C],
    target: &Target<C>,
    starts: Starts,
    most: f32,
) -> (Line<C>, f32) {
    let found = fit(channels, target, starts, most);
    let line = Line {
        ends: found.ends,
        positions: positions(channels, target, &found.ends),
    };
    (line, found.error)
}

/// Encodes the colour half of BC3 blocks from details.
pub struct DetailEncoder<'a> {
    coding: &'a PlaneCoding,
    channels: [Channel; 3],
    starts: Starts,
}

impl<'a> DetailEncoder<'a> {
    /// Makes an encoder for a plane whose details are stored without a transform.
    pub fn new(coding: &'a PlaneCoding, starts: Starts) -> Self {
        let channel = |c: usize, levels| Channel::new(levels, |v| coding.load_detail(c, v));
        Self {
            coding,
            channels: [channel(0, 32), channel(1, 64), channel(2, 32)],
            starts,
        }
    }

    /// Encodes 4 x 4 details, and returns the block and its squared error.
    pub fn block(&self, details: &[Details; 16]) -> ([u8; 8], f32) {
        let expected: [[f32; 16]; 3] = std::array::from_fn(|c| details.map(|d| d[c]));
        let stored = std::array::from_fn(|c| expected[c].map(|v| self.coding.store_detail(c, v)));
        let target = Target { expected, stored };
        let (line, error) = fitted(&self.channels, &target, self.starts, f32::INFINITY);
        (color_block(line), error)
    }
}

/// Encodes BC1 blocks from colours.
pub struct ColorEncoder {
    channels: [Channel; 3],
    with_black: [Channel; 3],
    starts: Starts,
}

/// Texels with no channel above this may be black, and are left out where the line of the others is sought.
const DARK: f32 = 0.15;

/// Returns whether a texel may be black.
pub fn is_dark(color: &[f32; 3]) -> bool {
    color.iter().all(|v| *v <= DARK)
}

impl ColorEncoder {
    /// Makes an encoder.
    pub fn new(starts: Starts) -> Self {
        const LEVELS: [usize; 3] = [32, 64, 32];
        Self {
            channels: LEVELS.map(|levels| Channel::new(levels, |v| v)),
            with_black: LEVELS.map(Channel::with_black),
            starts,
        }
    }

    /// Encodes 4 x 4 colours in `[0, 1]` as four colours on a line, and returns the block and its squared error.
    pub fn block(&self, colors: &[[f32; 3]; 16]) -> ([u8; 8], f32) {
        let expected: [[f32; 16]; 3] = std::array::from_fn(|c| colors.map(|color| color[c]));
        let target = Target {
            expected,
            stored: expected,
        };
        let (line, error) = fitted(&self.channels, &target, self.starts, f32::INFINITY);
        (color_block(line), error)
    }

    /// Refines the blocks of a level of `size` texels by the pixels between them, to which `equations` belong. Blocks
    /// with black stay.
    pub fn refine(&self, blocks: &mut [[u8; 8]], equations: NormalEquations<3>, size: [u32; 2]) {
        let line = |block: &[u8; 8]| {
            let ([a, b], positions) = line_of(block)?;
            let ends = [0, 1, 2].map(|c| [a[c], b[c]]);
            Some(Line { ends, positions })
        };
        let lines = blocks.iter().map(line).collect();
        let texels = decode_blocks(BlockFormat::Bc1, blocks.as_flattened(), size);
        let values = [0, 1, 2].map(|c: usize| texels.iter().map(|t| t[c]).collect());
        let interpolated = Interpolated {
            channels: &self.channels,
            equations,
            size,
            columns: size[0].div_ceil(4) as usize,
        };
        interpolated.refine(blocks, lines, values, color_block);
    }

    /// The same as three colours on a line and black, of which an error that is more than `most` is of no use.
    pub fn block_with_black(&self, colors: &[[f32; 3]; 16], most: f32) -> ([u8; 8], f32) {
        let expected: [[f32; 16]; 3] = std::array::from_fn(|c| colors.map(|color| color[c]));
        let mut is_dark = colors.each_ref().map(is_dark);
        let others = is_dark.iter().filter(|dark| !**dark).count();
        if others == 0 {
            is_dark = [false; 16];
        }
        let stored = expected.map(|values| {
            let pairs = values.iter().zip(is_dark);
            let sum: f32 = pairs.map(|(v, dark)| if dark { 0.0 } else { *v }).sum();
            let mean = sum / others.max(1) as f32;
            std::array::from_fn(|i| if is_dark[i] { mean } else { values[i] })
        });
        let target = Target { expected, stored };
        let (line, error) = fitted(&self.with_black, &target, self.starts, most);
        (color_block_with_black(line), error)
    }
}

/// Encodes BC1 blocks of two planes.
pub struct ChromaEncoder<'a> {
    codings: &'a [PlaneCoding; 2],
    channels: [Channel; 2],
    /// Square roots of the weights of the planes' squared errors.
    weights: [f32; 2],
    starts: Starts,
}

/// Number of values of the first channel, which is the mean of R and B of 5 bits each.
const PAIR_LEVELS: usize = 63;

impl<'a> ChromaEncoder<'a> {
    /// Makes an encoder. `weights` are those of the planes' squared errors.
    pub fn new(codings: &'a [PlaneCoding; 2], weights: [f32; 2], starts: Starts) -> Self {
        let weights = weights.map(f32::sqrt);
        let channel =
            |c: usize, levels| Channel::new(levels, |v| weights[c] * codings[c].load_low(v));
        Self {
            codings,
            channels: [channel(0, PAIR_LEVELS), channel(1, 64)],
            weights,
            starts,
        }
    }

    /// Encodes 4 x 4 values of both planes.
    pub fn block(&self, values: &[[f32; 2]; 16]) -> [u8; 8] {
        let of = |c: usize| values.map(|v| v[c]);
        let target = Target {
            expected: [0, 1].map(|c| of(c).map(|v| self.weights[c] * v)),
            stored: [0, 1].map(|c| of(c).map(|v| self.codings[c].store_low(v))),
        };
        chroma_block(fitted(&self.channels, &target, self.starts, f32::INFINITY).0)
    }

    /// Refines the blocks of a level of `size` values, in rows of `columns`, by the pixels between them, to which
    /// `equations` belong.
    pub fn refine(
        &self,
        blocks: &mut [[u8; 8]],
        mut equations: NormalEquations<2>,
        size: [u32; 2],
        columns: usize,
    ) {
        let line = |block: &[u8; 8]| {
            let ([a, b], positions) = line_of(block)?;
            let ends = [[a[0] + a[2], b[0] + b[2]], [a[1], b[1]]];
            Some(Line { ends, positions })
        };
        let lines: Vec<Option<Line<2>>> = blocks.iter().map(line).collect();
        let [width, height] = size.map(|s| s as usize);
        let values = [0, 1].map(|c: usize| {
            let value = |i: usize| {
                let (x, y) = (i % width, i / width);
                let line = &lines[y / 4 * columns + x / 4].expect("chroma has no black");
                let position = line.positions[y % 4 * 4 + x % 4];
                self.channels[c].palette(line.ends[c])[position as usize]
            };
            (0..width * height).map(value).collect()
        });
        for (values, weight) in equations.right_sides.iter_mut().zip(self.weights) {
            values.iter_mut().for_each(|v| *v *= weight);
        }
        let interpolated = Interpolated {
            channels: &self.channels,
            equations,
            size,
            columns,
        };
        interpolated.refine(blocks, lines, values, chroma_block);
    }
}

/// The endpoints of a block, as levels of R, G and B, and the positions of its texels on the line between them. `None`
/// where it is in the mode of three colours and black.
fn line_of(block: &[u8; 8]) -> Option<([[u8; 3]; 2], [u8; 16])> {
    let [a, b, c, d, indices @ ..] = *block;
    let ends = [[a, b], [c, d]].map(u16::from_le_bytes);
    let indices = u32::from_le_bytes(indices);
    if ends[0] < ends[1] || ends[0] == ends[1] && indices != 0 {
        return None;
    }
    let levels = ends.map(|end| [end >> 11, end >> 5 & 63, end & 31].map(|level| level as u8));
    let position = |i: usize| [0, 3, 1, 2][(indices >> (2 * i) & 3) as usize];
    Some((levels, std::array::from_fn(position)))
}

/// The endpoints of a line of colours, of 5, 6 and 5 bits.
fn colors([r, g, b]: [[u8; 2]; 3]) -> [u16; 2] {
    [0, 1].map(|e| u16::from(r[e]) << 11 | u16::from(g[e]) << 5 | u16::from(b[e]))
}

/// Packs a block of colours on a line, at the positions 0 to 3.
///
/// The larger colour comes first. In BC1 that selects the mode of four colours; in BC3 the order
/// has no meaning, and no decoder can misread it.
fn color_block(line: Line<3>) -> [u8; 8] {
    let ([mut first, mut second], mut positions) = (colors(line.ends), line.positions);
    if first < second {
        (first, second) = (second, first);
        positions = positions.map(|position| 3 - position);
    } else if first == second {
        positions = [0; 16];
    }
    // Index 1 is the second colour; 2 and 3 are interpolated.
    packed_block([first, second], positions.map(|p| [0, 2, 3, 1][p as usize]))
}

/// The same of three colours on the line, 0 to 2, and black, 3. The larger colour comes second.
fn color_block_with_black(line: Line<3>) -> [u8; 8] {
    let ([mut first, mut second], mut positions) = (colors(line.ends), line.positions);
    if first > second {
        (first, second) = (second, first);
        positions = positions.map(|position| [2, 1, 0, 3][position as usize]);
    }
    // Index 2 is the middle.
    packed_block([first, second], positions.map(|p| [0, 2, 1, 3][p as usize]))
}

/// The same of two planes, the first of which is the mean of R and B.
fn chroma_block(line: Line<2>) -> [u8; 8] {
    let [pair, g] = line.ends;
    let ends = [pair.map(|v| v.div_ceil(2)), g, pair.map(|v| v / 2)];
    color_block(Line {
        ends,
        positions: line.positions,
    })
}

fn packed_block([first, second]: [u16; 2], indices: [u32; 16]) -> [u8; 8] {
    let indices = (0..16).fold(0, |bits, i| bits | indices[i] << (2 * i));
    let mut block = [0; 8];
    block[..2].copy_from_slice(&first.to_le_bytes());
    block[2..4].copy_from_slice(&second.to_le_bytes());
    block[4..].copy_from_slice(&indices.to_le_bytes());
    block
}

/// Interleaves alpha blocks (BC4) and colour blocks to BC3 blocks.
///
/// # Panics
/// Panics when the two do not have the same number of blocks.
pub fn with_alpha_blocks(alpha: &[u8], color: &[[u8; 8]]) -> Vec<u8> {
    let (alpha, _) = alpha.as_chunks::<8>();
    assert_eq!(alpha.len(), color.len());
    let halves = alpha.iter().zip(color);
    halves.flat_map(|(a, c)| [*a, *c]).flatten().collect()
}

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
    let formats = (dds::ColorFormat::RGBA_U8, dds::Format::BC3_UNORM);
    with_dds(texels.as_flattened(), size, formats, quality)
}

/// Encodes the same as opaque BC1, a baseline for wavelet textures.
///
/// # Panics
/// Panics when `texels` does not have `size` texels.
pub fn encode_bc1(texels: &[Texel], size: [u32; 2], quality: BlockQuality) -> Vec<u8> {
    let formats = (dds::ColorFormat::RGBA_U8, dds::Format::BC1_UNORM);
    with_dds(texels.as_flattened(), size, formats, quality)
}

/// Encodes values in `[0, 1]` as BC4.
///
/// # Panics
/// Panics when `values` does not have `size` values.
pub fn encode_bc4(values: &[f32], size: [u32; 2], quality: BlockQuality) -> Vec<u8> {
    let bytes: Vec<[u8; 4]> = values.iter().map(|v| v.to_ne_bytes()).collect();
    let formats = (dds::ColorFormat::GRAYSCALE_F32, dds::Format::BC4_UNORM);
    with_dds(bytes.as_flattened(), size, formats, quality)
}

fn with_dds(
    bytes: &[u8],
    [width, height]: [u32; 2],
    (color, format): (dds::ColorFormat, dds::Format),
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
    use crate::codec::blocks::decode_bc3;
    use proptest::prelude::*;

    fn coding() -> PlaneCoding {
        PlaneCoding {
            range: 0.4,
            gamma: 0.6,
            ..PlaneCoding::linear([-0.5, 0.5])
        }
    }

    proptest! {
        /// The error that the fit returns is that of the block it encodes.
        #[test]
        fn a_block_decodes_to_what_the_fit_promised(seed in any::<u64>(), spread in 0.0f32..0.6) {
            let mut state = seed | 1;
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                ((state >> 40) as f32 / (1 << 24) as f32 - 0.5) * spread
            };
            let details: [Details; 16] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
            let coding = coding();
            let mut errors = Vec::new();
            for starts in [Starts::One, Starts::Two, Starts::Four] {
                let (block, promised) = DetailEncoder::new(&coding, starts).block(&details);
                let texels = decode_blocks(BlockFormat::Bc1, &block, [4, 4]);
                let error: f32 = texels.iter().zip(&details).flat_map(|(t, d)| {
                    let back = coding.load_details([t[0], t[1], t[2]]);
                    [0, 1, 2].map(|c| (back[c] - d[c]).powi(2))
                }).sum();
                prop_assert!((error - promised).abs() <= 1e-5 + 1e-3 * promised, "{error} {promised}");
                errors.push(promised);
            }
            prop_assert!(errors[2] <= errors[0].min(errors[1]));
        }
    }

    #[test]
    fn black_beside_a_line_of_colours_has_no_error_of_its_own() {
        let colors: [[f32; 3]; 16] = std::array::from_fn(|i| match i % 4 {
            3 => [0.0; 3],
            t => [1.0, t as f32 / 2.0, 0.0],
        });
        let encoder = ColorEncoder::new(Starts::Four);
        let (block, promised) = encoder.block_with_black(&colors, f32::INFINITY);
        let texels = decode_blocks(BlockFormat::Bc1, &block, [4, 4]);
        let pairs = texels.iter().zip(&colors);
        let error = pairs.map(|(t, c)| (0..3).map(|i| (t[i] - c[i]).powi(2)).sum::<f32>());
        let error: f32 = error.sum();
        assert!(
            error < 1e-3 && (error - promised).abs() < 1e-5,
            "{error} {promised}"
        );
        assert!(encoder.block(&colors).1 > 0.1);
    }

    /// Of two colours that no endpoint has, a position between the endpoints comes nearer.
    #[test]
    fn two_colours_lie_wherever_they_are_nearest() {
        let [first, second] = [[5.0, 119.0, 0.0], [4.0, 182.0, 0.0]].map(|c| c.map(|v| v / 255.0));
        let colors = std::array::from_fn(|i| if i < 4 { second } else { first });
        let error = ColorEncoder::new(Starts::Two).block(&colors).1;
        assert!(error < 1.3e-3, "{error}");
    }

    #[test]
    fn chroma_of_one_colour_is_within_half_a_step() {
        let codings = [coding(), coding()];
        let encoder = ChromaEncoder::new(&codings, [0.5, 0.7], Starts::One);
        for value in [[-0.5, 0.5], [0.1, -0.2], [0.0, 0.0], [0.499, 0.3]] {
            let block = encoder.block(&[value; 16]);
            for texel in decode_blocks(BlockFormat::Bc1, &block, [4, 4]) {
                let pair = codings[0].load_low((texel[0] + texel[2]) / 2.0);
                let green = codings[1].load_low(texel[1]);
                assert!(
                    (pair - value[0]).abs() <= 0.5 / 62.0 + 1e-6,
                    "{pair} {value:?}"
                );
                assert!(
                    (green - value[1]).abs() <= 0.5 / 63.0 + 1e-6,
                    "{green} {value:?}"
                );
            }
        }
    }

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

//! How the driver decodes BC3, whose format leaves the rounding of interpolated values to it, and images whose texels
//! are the same in every decoder.
//!
//! Lavapipe, for one, makes the end points `a` and `b` bytes (bits repeated) and step `w` of `n`
//! between them `a + ((b - a) * (255 * w / n) >> 8)` in integers: up to 1.7 levels off.

use bevy_frugal_lab::headless::HeadlessSettings;
use bevy_wavelet_tex::codec::{
    axes::ColorAxes,
    blocks::{BlockFormat, decode_bc3},
    haar::Transform,
    image::{ColorSpace, Content, Payload, PlaneGroup, WaveletImage, WaveletPlanes},
    packing::Packing,
    quantizer::PlaneCoding,
};

use super::scene::{app, driver_texels};
use crate::support::gpu;

fn decoded_by_the_driver(blocks: &[u8], size: [u32; 2]) -> Vec<[f32; 4]> {
    let app = app(HeadlessSettings::with_size(16, 16));
    driver_texels(&app, BlockFormat::Bc3, blocks, size)
}

/// The block whose texels are all end point `index`, 0 or 1.
fn with_all_indices(block: &[u8; 16], index: u64) -> [u8; 16] {
    let mut block = *block;
    block[2..8].copy_from_slice(&(index * 0x2492_4924_9249).to_le_bytes()[..6]);
    block[12..].copy_from_slice(&(index as u32 * 0x5555_5555).to_le_bytes());
    block
}

/// Blocks with every bit pattern equally likely.
fn random_blocks(count: usize) -> Vec<[u8; 16]> {
    let mut state = 1u64;
    let mut next = || {
        // SplitMix64.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut block = || bytemuck::cast([next(), next()]);
    (0..count).map(|_| block()).collect()
}

#[test]
fn the_driver_decodes_blocks_within_its_freedom_to_round() {
    let _gpu = gpu();
    let blocks = random_blocks(64 * 64);
    let size = [256, 256];
    let driver = decoded_by_the_driver(blocks.as_flattened(), size);
    let exact = decode_bc3(blocks.as_flattened(), size);
    let [end_0, end_1] = [0, 1].map(|index| {
        let all = |block: &[u8; 16]| with_all_indices(block, index);
        decode_bc3(&blocks.iter().flat_map(all).collect::<Vec<_>>(), size)
    });
    let mut worst = [0.0f32; 4];
    for texel in 0..exact.len() {
        for (channel, worst) in worst.iter_mut().enumerate() {
            let of = |texels: &[[f32; 4]]| texels[texel][channel];
            let difference = (of(&driver) - of(&exact)).abs();
            *worst = worst.max(difference * 255.0);
            // Vulkan gives no bound. Direct3D 11 allows one level and 3 % of the way between the end
            // points; half a level is for end points made bytes before they are mixed.
            let tolerance = 1.5 / 255.0 + 0.03 * (of(&end_0) - of(&end_1)).abs();
            assert!(
                difference <= tolerance,
                "texel {texel}, channel {channel}: {difference}"
            );
        }
    }
    println!("levels off in R, G, B, A: {worst:.3?}");
}

const SIZE: [u32; 2] = [64, 40];

/// Nothing in the block is interpolated. Alpha has 8 bits at its end points; 5:6:5 colours are whole bytes at 0 and 31
/// of 31, and at 0, 21, 42 and 63 of 63.
fn without_rounding(mut block: [u8; 16]) -> [u8; 16] {
    for end in [8, 10] {
        let bits = u16::from_le_bytes([block[end], block[end + 1]]);
        let [red, blue] = [bits >> 11 & 1, bits & 1].map(|on| on * 31);
        let green = (bits >> 5 & 3) * 21;
        let color = red << 11 | green << 5 | blue;
        block[end..end + 2].copy_from_slice(&color.to_le_bytes());
    }
    // Indices 0 and 1 only: the lowest of the 3 bits of alpha and of the 2 bits of colour.
    for (indices, lowest) in [(2..8, 0x2492_4924_9249u64), (12..16, 0x5555_5555)] {
        for (byte, mask) in block[indices].iter_mut().zip(lowest.to_le_bytes()) {
            *byte &= mask;
        }
    }
    block
}

/// Gray and colour of every storable detail and mean, in YCoCg and along other axes; chroma in wavelets, as the thesis
/// has it.
pub fn exact_images() -> Vec<WaveletImage> {
    let coding = |mean: [f32; 2], range, gamma, w| PlaneCoding {
        range,
        gamma,
        transform: Transform::PartiallyInvertedHaar { w },
        ..PlaneCoding::linear(mean)
    };
    let luma = PlaneCoding {
        predictor: 0.16,
        ..coding([0.1, 0.9], 0.1, 0.8, 0.6)
    };
    let [co, cg] = [-0.3, -0.2].map(|min| coding([min, 0.25], 0.05, 0.7, 0.4));
    let group = |subsampling, codings: Vec<PlaneCoding>| {
        let mut group = PlaneGroup {
            subsampling,
            packing: Packing::Bc3,
            codings,
            textures: Vec::new(),
        };
        let [width, height] = group.texture_size(SIZE);
        let blocks = random_blocks(group.layers() * (width * height / 16) as usize);
        let blocks = blocks.into_iter().flat_map(without_rounding);
        group.textures.push(blocks.collect());
        group
    };
    let image = |content: Content, color_space, axes| WaveletImage {
        content,
        color_space,
        size: SIZE,
        levels: 1,
        payload: Payload::Wavelet(WaveletPlanes {
            axes,
            luma: group(0, vec![luma]),
            chroma: content.has_chroma().then(|| group(1, vec![co, cg])),
        }),
    };
    let fitted = ColorAxes {
        rgb: [[0.9, 1.1, 0.8], [0.6, -0.3, -0.4], [-0.2, 0.5, -0.7]],
    };
    vec![
        image(Content::Gray, ColorSpace::Linear, ColorAxes::YCOCG),
        image(Content::Gray, ColorSpace::Srgb, ColorAxes::YCOCG),
        image(Content::Color, ColorSpace::Srgb, ColorAxes::YCOCG),
        image(Content::Color, ColorSpace::Srgb, fitted),
    ]
}

#[test]
fn the_driver_decodes_blocks_without_interpolation_exactly() {
    let _gpu = gpu();
    let blocks = random_blocks(256).into_iter().flat_map(without_rounding);
    let blocks: Vec<u8> = blocks.collect();
    let driver = decoded_by_the_driver(&blocks, [64, 64]);
    for (driver, exact) in driver.iter().zip(decode_bc3(&blocks, [64, 64])) {
        for (a, b) in driver.iter().zip(exact) {
            assert!((a - b).abs() < 1e-6, "{a} is not {b}");
        }
    }
}

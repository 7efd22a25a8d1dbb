//! Images whose BC3 texels are the same in every decoder: nothing in them is interpolated.

use bevy_wavelet_tex::codec::{
    axes::ColorAxes,
    blocks::decode_bc3,
    haar::Transform,
    image::{ColorSpace, Content, PlaneGroup, WaveletImage},
    packing::Packing,
    quantizer::PlaneCoding,
};

use super::driver::{Driver, random_blocks};
use crate::support::gpu;

const SIZE: [u32; 2] = [64, 40];

/// Alpha has 8 bits at its end points; 5:6:5 colours are whole bytes at 0 and 31 of 31, and at 0,
/// 21, 42 and 63 of 63.
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
    let image = |content: Content, color_space| WaveletImage {
        content,
        color_space,
        axes: ColorAxes::YCOCG,
        size: SIZE,
        levels: 1,
        plain: None,
        groups: if content.has_chroma() {
            vec![group(0, vec![luma]), group(1, vec![co, cg])]
        } else {
            vec![group(0, vec![luma])]
        },
    };
    let fitted = ColorAxes {
        rgb: [[0.9, 1.1, 0.8], [0.6, -0.3, -0.4], [-0.2, 0.5, -0.7]],
    };
    vec![
        image(Content::Gray, ColorSpace::Linear),
        image(Content::Gray, ColorSpace::Srgb),
        image(Content::Color, ColorSpace::Srgb),
        WaveletImage {
            axes: fitted,
            ..image(Content::Color, ColorSpace::Srgb)
        },
    ]
}

#[test]
fn the_driver_decodes_blocks_without_interpolation_exactly() {
    let _gpu = gpu();
    let blocks: Vec<u8> = random_blocks(256)
        .into_iter()
        .flat_map(without_rounding)
        .collect();
    let driver = Driver::new().decode_bc3(&blocks, [64, 64]);
    for (driver, exact) in driver.iter().zip(decode_bc3(&blocks, [64, 64])) {
        for (a, b) in driver.iter().zip(exact) {
            assert!((a - b).abs() < 1e-6, "{a} is not {b}");
        }
    }
}

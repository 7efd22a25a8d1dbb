//! The edges of the domain: no value from a material may spread or be anything but a colour.

use bevy::prelude::*;
use bevy::render::view::Msaa;
use bevy_ycocg_fb::{
    MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer, reference::PackedImage,
};

use super::{
    exact::{STEP, largest_difference},
    flat::{Flat, random_colors},
};
use crate::support::gpu;

const BAD: [[f32; 3]; 10] = [
    [f32::NAN; 3],
    [f32::NAN, 1.0, 2.0],
    [f32::INFINITY; 3],
    [f32::INFINITY, 0.0, 1.0],
    [f32::NEG_INFINITY, 1.0, 1.0],
    [65504.0; 3],
    [65504.0, 0.0, 0.0],
    [1e30, 1.0, 0.0],
    [1e-7, 0.0, 2e-7],
    [-3.0, 0.5, 0.5],
];

#[test]
fn one_bad_pixel_is_one_bad_pixel() {
    let _gpu = gpu();
    let size = [24, 20];
    for (i, bad) in BAD.into_iter().enumerate() {
        let mut colors = random_colors(size, 3);
        // Both parities.
        for (x, y) in [(7, 6), (15, 13)] {
            colors[y * size[0] as usize + x] = bad;
        }
        let mut flat = Flat::new(size, size, [0, 0], &colors);
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            for reconstruction in [
                Reconstruction::Guided,
                Reconstruction::Wide,
                Reconstruction::EdgeDirected,
            ] {
                let actual = flat.packed(YCoCgFrameBuffer {
                    format,
                    reconstruction,
                    ..default()
                });
                let image = PackedImage::pack(&colors, size, [0, 0], format);
                let expected = image.unpack(reconstruction);
                let difference = largest_difference_of_pixels(&actual, &expected);
                // 1e-7 is two steps of a 16-bit float, and which of them is up to the driver.
                let subnormal = bad[0] == 1e-7 && format == PackedFormat::Float16;
                let allowed = if subnormal { 0.02 } else { STEP };
                assert!(
                    difference < allowed,
                    "{i} {format:?} {reconstruction:?}: {difference}"
                );
                assert!(actual.iter().flatten().all(|c| (0.0..=65504.0).contains(c)));
                // Two pixels away nothing has changed.
                let clean = PackedImage::pack(&random_colors(size, 3), size, [0, 0], format)
                    .unpack(reconstruction);
                for (index, (actual, clean)) in actual.iter().zip(&clean).enumerate() {
                    let (x, y) = (index as i32 % 24, index as i32 / 24);
                    let distance = [(7, 6), (15, 13)]
                        .map(|(bx, by)| (x - bx).abs().max((y - by).abs()))
                        .into_iter()
                        .min();
                    if distance > Some(1) {
                        assert!(largest_difference(&[*actual], &[*clean], 0.05) < STEP);
                    }
                }
            }
        }
    }
}

#[test]
fn stacking_light_until_it_overflows_is_as_bright_as_can_be() {
    let _gpu = gpu();
    let size = [16, 12];
    let colors = vec![[60000.0, 30000.0, 10000.0]; 16 * 12];
    let mut flat = Flat::new(size, size, [0, 0], &colors);
    flat.stack(7, AlphaMode::Add);
    for msaa in [Msaa::Off, Msaa::Sample4] {
        flat.set_msaa(msaa);
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            for msaa_resolve in [MsaaResolve::Box, MsaaResolve::ToneMapWeighted] {
                let actual = flat.packed(YCoCgFrameBuffer {
                    format,
                    msaa_resolve,
                    ..default()
                });
                for pixel in actual {
                    assert!(
                        pixel.iter().all(|c| c.is_finite() && *c >= 0.0),
                        "{pixel:?}"
                    );
                    assert!(pixel[0] == 65504.0, "{format:?} {msaa:?}: {pixel:?}");
                }
            }
        }
    }
}

/// Relative to the brightest channel of each pixel: what is stored is rounded before channels of
/// very different size are told apart again.
fn largest_difference_of_pixels(actual: &[[f32; 3]], expected: &[[f32; 3]]) -> f32 {
    let pairs = actual.iter().zip(expected);
    pairs.fold(0.0, |largest: f32, (actual, expected)| {
        let brightest = expected.iter().copied().fold(0.05, f32::max);
        largest.max(largest_difference(&[*actual], &[*expected], brightest))
    })
}

//! The shaders compute what the reference computes.
//!
//! The colours are such that all packed values are exact in 16 bits, so that what remains is the
//! rounding of 32-bit arithmetic and of Bevy's 16-bit main texture.

use bevy::prelude::*;
use bevy_ycocg_fb::{PackedFormat, Reconstruction, YCoCgFrameBuffer, reference::PackedImage};

use super::flat::{Flat, random_colors};
use crate::support::gpu;

const ALL: [Reconstruction; 6] = [
    Reconstruction::Nearest,
    Reconstruction::Bilinear,
    Reconstruction::EdgeDirected,
    Reconstruction::Guided,
    Reconstruction::Wide,
    Reconstruction::Quad,
];

/// The step of a 16-bit float, to either side of which a target may round, and some arithmetic.
pub const STEP: f32 = 1.1 / 1024.0;

/// The largest difference relative to the larger of the value and `floor`.
pub fn largest_difference(actual: &[[f32; 3]], expected: &[[f32; 3]], floor: f32) -> f32 {
    assert_eq!(actual.len(), expected.len());
    let pairs = actual.iter().flatten().zip(expected.iter().flatten());
    pairs.fold(0.0, |largest, (actual, expected)| {
        assert!(actual.is_finite(), "{actual} instead of {expected}");
        largest.max((actual - expected).abs() / expected.abs().max(floor))
    })
}

#[test]
fn every_filter_at_every_size_and_offset_is_that_of_the_reference() {
    let _gpu = gpu();
    for (size, offset) in [
        ([37, 23], [0, 0]),
        ([36, 22], [1, 0]),
        ([31, 21], [3, 5]),
        ([30, 20], [2, 7]),
        ([1, 23], [0, 0]),
        ([1, 22], [1, 1]),
        ([37, 1], [0, 0]),
        ([36, 1], [0, 1]),
        ([2, 2], [5, 4]),
        ([1, 1], [0, 0]),
        ([1, 1], [2, 3]),
    ] {
        let colors = random_colors(size, 5);
        let mut flat = Flat::new([40, 28], size, offset, &colors);
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            let image = PackedImage::pack(&colors, size, offset, format);
            for reconstruction in ALL {
                let actual = flat.packed(YCoCgFrameBuffer {
                    reconstruction,
                    ..YCoCgFrameBuffer::with_format(format)
                });
                let expected = image.unpack(reconstruction);
                let difference = largest_difference(&actual, &expected, 0.05);
                assert!(
                    difference < STEP,
                    "{size:?} at {offset:?} {format:?} {reconstruction:?}: {difference}"
                );
            }
        }
    }
}

#[test]
fn a_neighbouring_viewport_changes_nothing() {
    // A neighbour in the next viewport is none: beside another picture the result is the same.
    let _gpu = gpu();
    let size = [20, 16];
    let colors = random_colors(size, 9);
    let mut alone = Flat::new([20, 16], size, [0, 0], &colors);
    let mut beside = Flat::new([40, 16], size, [20, 0], &colors);
    let bright = vec![[4.0, 0.0, 0.0]; 20 * 16];
    beside.add_camera(size, [0, 0], &bright);
    for reconstruction in ALL {
        let settings = YCoCgFrameBuffer {
            reconstruction,
            ..default()
        };
        assert!(
            alone.packed(settings) == beside.packed(settings),
            "{reconstruction:?}"
        );
    }
}

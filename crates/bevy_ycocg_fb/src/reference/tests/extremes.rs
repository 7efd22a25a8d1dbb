//! Extreme values: 65504, 1e-7, NaN and infinity.

use proptest::prelude::*;

use super::{FILTERS, GUIDED_FILTERS, relative_error, round_trip};
use crate::{
    reference::{PackedImage, PackedPixel, pack::F16_MAX},
    settings::PackedFormat,
};

#[test]
fn the_brightest_colours_round_trip() {
    for color in [[F16_MAX; 3], [F16_MAX, 0.0, 0.0], [0.0, F16_MAX, 16.0]] {
        for filter in FILTERS {
            for shown in round_trip([4, 4], [0, 0], PackedFormat::Float16, filter, |_, _| color) {
                let error = relative_error(shown, color);
                assert!(error < 1.5e-3, "{filter:?} {color:?}: {shown:?}");
            }
        }
    }
}

/// Below `FLOOR`, the reconstructed chrominance fades to 0; the error is less than a millionth.
#[test]
fn the_darkest_colours_round_trip_to_a_millionth() {
    for color in [[1e-7; 3], [1e-7, 0.0, 3e-7], [0.0; 3], [2e-5, 1e-7, 0.0]] {
        for filter in FILTERS {
            for format in [PackedFormat::Float16, PackedFormat::Float32] {
                for shown in round_trip([4, 4], [0, 0], format, filter, |_, _| color) {
                    for (a, e) in shown.into_iter().zip(color) {
                        assert!((a - e).abs() < 1e-6, "{filter:?} {color:?}: {shown:?}");
                    }
                }
            }
        }
    }
}

/// NaN or infinity of a material in one pixel has no more effect on the others than black or white.
#[test]
fn a_bad_pixel_of_a_material_does_not_spread() {
    let wall = [0.5, 0.25, 0.125];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -5.0] {
        for filter in FILTERS {
            let color = |x: u32, y: u32| if [x, y] == [3, 3] { [bad; 3] } else { wall };
            let shown = round_trip([7, 7], [0, 0], PackedFormat::Float16, filter, color);
            assert!(shown.iter().flatten().all(|channel| channel.is_finite()));
            if GUIDED_FILTERS.contains(&filter) {
                check_all_but_the_middle(&shown, wall);
            }
        }
    }
}

/// A target can hold values that no material wrote, because additive blending can overflow.
#[test]
fn a_bad_pixel_of_the_target_does_not_spread() {
    let wall = [0.5, 0.25, 0.125];
    let values = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        65504.0,
        -65504.0,
        0.0,
    ];
    for luminance in values {
        for chrominance in values {
            let format = PackedFormat::Float16;
            let mut image = PackedImage::pack(&[wall; 49], [7, 7], [0, 0], format);
            image.pixels[24] = PackedPixel {
                luminance,
                chrominance,
            };
            for filter in FILTERS {
                let shown = image.unpack(filter);
                let finite = shown.iter().flatten().all(|channel| channel.is_finite());
                assert!(finite, "{filter:?} {luminance} {chrominance}");
                if GUIDED_FILTERS.contains(&filter) {
                    check_all_but_the_middle(&shown, wall);
                }
            }
        }
    }
}

fn check_all_but_the_middle(shown: &[[f32; 3]], wall: [f32; 3]) {
    for (i, shown) in shown.iter().enumerate() {
        let error = relative_error(*shown, wall);
        assert!(i == 24 || error < 2e-3, "pixel {i}: {shown:?}");
    }
}

proptest! {
    #[test]
    fn any_target_gives_finite_colours_that_are_not_negative(
        values in prop::collection::vec((any::<f32>(), any::<f32>()), 25),
    ) {
        let pixels = values.into_iter().map(|(luminance, chrominance)| PackedPixel {
            luminance,
            chrominance: chrominance.clamp(-F16_MAX, F16_MAX),
        });
        let image = PackedImage {
            offset: [0, 0],
            size: [5, 5],
            format: PackedFormat::Float16,
            pixels: pixels.collect(),
        };
        for filter in FILTERS {
            for channel in image.unpack(filter).into_iter().flatten() {
                prop_assert!(channel.is_finite() && channel >= 0.0, "{filter:?}: {channel}");
            }
        }
    }
}

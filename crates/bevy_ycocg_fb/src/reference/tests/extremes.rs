//! Extreme values and sizes: 65504, 1e-7, NaN and infinity; borders, viewports at odd offsets, and images of a single
//! row, column or pixel.

use proptest::prelude::*;

use super::{FILTERS, GUIDED_FILTERS, relative_error, round_trip};
use crate::{
    reference::{PackedImage, PackedPixel, image::mirrored, pack::F16_MAX},
    settings::{PackedFormat, Reconstruction},
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

#[test]
fn coordinates_mirror_at_the_centres_of_the_outermost_pixels() {
    let five: Vec<u32> = (-2..7).map(|x| mirrored(x, 5)).collect();
    assert_eq!(five, [2, 1, 0, 1, 2, 3, 4, 3, 2]);
    let two: Vec<u32> = (-1..3).map(|x| mirrored(x, 2)).collect();
    assert_eq!(two, [1, 0, 1, 0]);
    let one: Vec<u32> = (-1..2).map(|x| mirrored(x, 1)).collect();
    assert_eq!(one, [0, 0, 0]);
}

#[test]
fn neighbours_beyond_the_border_have_the_right_parity() {
    for size in [[2, 2], [3, 5], [8, 3]] {
        for offset in [[0, 0], [1, 0], [3, 5]] {
            let colors = vec![[1.0, 0.0, 0.0]; (size[0] * size[1]) as usize];
            let image = PackedImage::pack(&colors, size, offset, PackedFormat::Float32);
            for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
                let missing = if image.stores_co(x, y) { -0.25 } else { 0.5 };
                for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    let neighbour = image.read(i64::from(x) + dx, i64::from(y) + dy);
                    assert_eq!(neighbour.chrominance, missing, "{size:?} {x} {y} {dx} {dy}");
                }
            }
        }
    }
}

#[test]
fn a_row_or_a_column_keeps_its_colour() {
    let color = [0.75, 0.5, 0.125];
    for size in [[7, 1], [1, 7], [2, 1], [1, 2]] {
        for offset in [[0, 0], [1, 0]] {
            for filter in FILTERS {
                let format = PackedFormat::Float32;
                for shown in round_trip(size, offset, format, filter, |_, _| color) {
                    let error = relative_error(shown, color);
                    assert!(error < 1e-6, "{size:?} {filter:?}: {shown:?}");
                }
            }
        }
    }
}

/// A single pixel has only one chrominance; the other one is assumed to be 0, and luminance is exact.
#[test]
fn a_single_pixel_keeps_its_luminance() {
    let color = [0.75, 0.5, 0.125];
    for filter in FILTERS {
        let co = round_trip([1, 1], [0, 0], PackedFormat::Float32, filter, |_, _| color);
        assert_eq!(
            co,
            [[0.46875 + 0.3125, 0.46875, 0.46875 - 0.3125]],
            "{filter:?}"
        );
        let cg = round_trip([1, 1], [1, 0], PackedFormat::Float32, filter, |_, _| color);
        assert_eq!(cg, [[0.4375, 0.5, 0.4375]], "{filter:?}");
    }
}

/// If a viewport at an odd offset cuts a quad of the target, the partner in the quad is beyond the
/// border.
#[test]
fn quads_cut_by_the_border_take_the_mirrored_neighbour() {
    let colors: Vec<[f32; 3]> = (0..4).map(|x| [x as f32 + 1.0, 0.0, 0.0]).collect();
    let shown = PackedImage::pack(&colors, [4, 1], [1, 0], PackedFormat::Float32)
        .unpack(Reconstruction::Quad);
    for (shown, expected) in shown.into_iter().zip(colors) {
        assert!(relative_error(shown, expected) < 1e-6, "{shown:?}");
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

    /// The position of a viewport determines only the parity: an even shift changes nothing.
    #[test]
    fn an_even_shift_changes_nothing(
        colors in prop::collection::vec(prop::array::uniform3(0f32..4.0), 35),
        shift_x in 0u32..50,
        shift_y in 0u32..50,
    ) {
        for filter in FILTERS {
            let at = |offset| {
                PackedImage::pack(&colors, [7, 5], offset, PackedFormat::Float16).unpack(filter)
            };
            prop_assert_eq!(at([1, 2]), at([1 + 2 * shift_x, 2 + 2 * shift_y]));
        }
    }

    /// The filters commute with a transposition of the picture.
    #[test]
    fn guided_filters_commute_with_a_transposition(
        colors in prop::collection::vec(prop::array::uniform3(0f32..4.0), 36),
    ) {
        let transposed_colors: Vec<_> = (0..36).map(|i| colors[i % 6 * 6 + i / 6]).collect();
        for filter in GUIDED_FILTERS {
            let unpack = |colors: &[[f32; 3]]| {
                PackedImage::pack(colors, [6, 6], [0, 0], PackedFormat::Float32).unpack(filter)
            };
            let (original, transposed) = (unpack(&colors), unpack(&transposed_colors));
            for i in 0..36 {
                let error = relative_error(transposed[i], original[i % 6 * 6 + i / 6]);
                prop_assert!(error < 1e-5, "{filter:?} {i}: {error}");
            }
        }
    }
}

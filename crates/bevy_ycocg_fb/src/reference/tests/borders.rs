//! Mirroring, viewports at odd offsets, and images of a single row, column or pixel.

use proptest::prelude::*;

use super::{FILTERS, GUIDED_FILTERS, relative_error, round_trip};
use crate::{
    reference::{PackedImage, image::mirrored},
    settings::{PackedFormat, Reconstruction},
};

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

//! Properties that hold for every colour, position and filter: in flat areas, at edges, in noise, and with changed
//! exposure; for extreme values and sizes (65504, 1e-7, NaN and infinity; borders, viewports at odd offsets, and images
//! of a single row, column or pixel).

mod pixels;

use proptest::prelude::*;

use super::{
    pack::{F16_MAX, mirrored},
    reconstruct::{Cross, EDGE_THRESHOLD, bilinear, edge_directed, guided, nearest},
    *,
};
use crate::settings::{PackedFormat, Reconstruction};

const FILTERS: [Reconstruction; 6] = [
    Reconstruction::Nearest,
    Reconstruction::Bilinear,
    Reconstruction::EdgeDirected,
    Reconstruction::Guided,
    Reconstruction::Wide,
    Reconstruction::Quad,
];

/// The guided filters, which guarantee more than those of the thesis.
const GUIDED_FILTERS: [Reconstruction; 3] = [
    Reconstruction::Guided,
    Reconstruction::Wide,
    Reconstruction::Quad,
];

/// Packs and unpacks an image whose colours are a function of the pixel position.
fn round_trip(
    size: [u32; 2],
    offset: [u32; 2],
    format: PackedFormat,
    filter: Reconstruction,
    color: impl Fn(u32, u32) -> [f32; 3],
) -> Vec<[f32; 3]> {
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let colors: Vec<_> = positions.map(|(x, y)| color(x, y)).collect();
    PackedImage::pack(&colors, size, offset, format).unpack(filter)
}

/// Returns the largest difference of a channel, relative to the largest channel of the expected colour.
fn relative_error(actual: [f32; 3], expected: [f32; 3]) -> f32 {
    let scale = expected.iter().fold(1e-30f32, |a, b| a.max(b.abs()));
    let differences = actual.iter().zip(expected).map(|(a, e)| (a - e).abs());
    differences.fold(0.0, f32::max) / scale
}

/// Returns the largest relative error of a pixel after it was packed and unpacked.
fn largest_error(
    size: [u32; 2],
    offset: [u32; 2],
    format: PackedFormat,
    filter: Reconstruction,
    color: impl Fn(u32, u32) -> [f32; 3],
) -> f32 {
    let shown = round_trip(size, offset, format, filter, &color);
    let errors = shown.into_iter().enumerate().map(|(i, shown)| {
        let i = i as u32;
        relative_error(shown, color(i % size[0], i / size[0]))
    });
    errors.fold(0.0, f32::max)
}

const FLOATS: [PackedFormat; 2] = [PackedFormat::Float16, PackedFormat::Float32];

fn pixel(luminance: f32, chrominance: f32) -> PackedPixel {
    PackedPixel {
        luminance,
        chrominance,
    }
}

fn cross(right: PackedPixel, left: PackedPixel, below: PackedPixel, above: PackedPixel) -> Cross {
    Cross {
        horizontal: Some([right, left]),
        vertical: Some([below, above]),
    }
}

/// Listing 4.2, computed by hand for neighbours within the threshold, exactly at it and far beyond it.
#[test]
fn edge_directed_follows_listing_4_2() {
    let near = pixel(0.5 + 0.9 * EDGE_THRESHOLD, 0.1);
    let below = pixel(0.5 - 0.5 * EDGE_THRESHOLD, 0.4);
    let at = pixel(EDGE_THRESHOLD, 0.7);
    let far = pixel(0.9, 0.3);
    let center = pixel(0.0, 0.0);
    assert_eq!(
        edge_directed(pixel(0.5, 0.0), &cross(near, far, below, far)),
        0.25
    );
    // Without similar neighbours, the first one is taken.
    assert_eq!(
        edge_directed(pixel(9.0, 0.0), &cross(far, near, near, near)),
        0.3
    );
    // A difference of exactly the threshold is an edge.
    assert_eq!(
        edge_directed(center, &cross(at, pixel(0.1, 0.2), far, far)),
        0.2
    );
}

#[test]
fn nearest_takes_the_first_neighbour_and_bilinear_the_mean() {
    let all = cross(
        pixel(1.0, 1.0),
        pixel(2.0, 2.0),
        pixel(3.0, 3.0),
        pixel(4.0, 6.0),
    );
    assert_eq!((nearest(&all), bilinear(&all)), (1.0, 3.0));
}

/// If all neighbours are beyond an edge, the one with the most similar luminance has the largest weight,
/// while the thesis takes the first.
#[test]
fn an_isolated_pixel_follows_the_most_similar_neighbour() {
    let far = pixel(1e4, 5e3);
    let chrominance = guided(pixel(1.0, 0.0), &cross(far, far, far, pixel(2.0, -1.0)));
    assert!((chrominance + 0.5).abs() < 0.02, "{chrominance}");
}

/// The wide filter detects an edge between two colours of the same luminance, on either side of it.
#[test]
fn the_wide_filter_detects_edges_of_equal_luminance() {
    let color = |x: u32, _: u32| {
        if x < 4 {
            [0.8, 0.0, 0.0]
        } else {
            [0.0, 0.4, 0.0]
        }
    };
    let largest = |filter| largest_error([8, 8], [0, 0], PackedFormat::Float32, filter, color);
    let [bilinear, guided, wide] = [
        Reconstruction::Bilinear,
        Reconstruction::Guided,
        Reconstruction::Wide,
    ]
    .map(largest);
    assert!(bilinear > 0.2, "{bilinear}");
    assert!(guided < 0.05 * bilinear, "{guided}");
    assert!(wide < 0.01 * bilinear, "{wide}");
}

/// At the edge between a light of 10,000 and black, neither takes the other's colour.
#[test]
fn an_hdr_edge_does_not_leak() {
    let color = |x: u32, _: u32| {
        if x < 5 {
            [1e4, 4e3, 500.0]
        } else {
            [0.02, 0.03, 0.05]
        }
    };
    for filter in [Reconstruction::Guided, Reconstruction::Wide] {
        let error = largest_error([10, 10], [0, 0], PackedFormat::Float32, filter, color);
        assert!(error < 1e-4, "{filter:?}: {error}");
    }
}

/// On a surface of one colour the ratio is constant, so the result is exact for any change of the light.
#[test]
fn shading_does_not_change_the_colour_of_a_surface() {
    let color = |x: u32, y: u32| {
        let light = 0.01 * 1.7f32.powi((x * 3 + y * 5) as i32 % 17);
        [0.9 * light, 0.3 * light, 0.2 * light]
    };
    for filter in GUIDED_FILTERS {
        let error = largest_error([16, 16], [0, 0], PackedFormat::Float32, filter, color);
        assert!(error < 1e-5, "{filter:?}: {error}");
    }
}

#[test]
fn the_brightest_colours_round_trip() {
    for color in [[F16_MAX; 3], [F16_MAX, 0.0, 0.0], [0.0, F16_MAX, 16.0]] {
        for filter in FILTERS {
            let format = PackedFormat::Float16;
            let error = largest_error([4, 4], [0, 0], format, filter, |_, _| color);
            assert!(error < 1.5e-3, "{filter:?} {color:?}: {error}");
        }
    }
}

/// Below `FLOOR`, the reconstructed chrominance fades to 0; the error is less than a millionth.
#[test]
fn the_darkest_colours_round_trip_to_a_millionth() {
    for color in [[1e-7; 3], [1e-7, 0.0, 3e-7], [0.0; 3], [2e-5, 1e-7, 0.0]] {
        for filter in FILTERS {
            for format in FLOATS {
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
                let error = largest_error(size, offset, format, filter, |_, _| color);
                assert!(error < 1e-6, "{size:?} {filter:?}: {error}");
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
    let color = |x: u32, _: u32| [x as f32 + 1.0, 0.0, 0.0];
    let (format, filter) = (PackedFormat::Float32, Reconstruction::Quad);
    let error = largest_error([4, 1], [1, 0], format, filter, color);
    assert!(error < 1e-6, "{error}");
}

proptest! {
    #[test]
    fn gray_is_exact(value in 0f32..65504.0) {
        for filter in FILTERS {
            for format in FLOATS {
                for shown in round_trip([5, 4], [0, 0], format, filter, |_, _| [value; 3]) {
                    let tolerance = if format == PackedFormat::Float16 { 6e-4 } else { 1e-6 };
                    prop_assert_eq!(shown[0], shown[1]);
                    prop_assert_eq!(shown[1], shown[2]);
                    let error = (shown[0] - value).abs();
                    prop_assert!(error <= tolerance * value + 3e-8, "{shown:?}");
                }
            }
        }
    }

    /// Gray noise stays gray with every filter.
    #[test]
    fn gray_noise_stays_gray(values in prop::collection::vec(0f32..2.0, 36)) {
        let color = |x: u32, y: u32| [values[(y * 6 + x) as usize]; 3];
        for filter in FILTERS {
            let shown = round_trip([6, 6], [0, 0], PackedFormat::Float32, filter, color);
            for (shown, value) in shown.into_iter().zip(&values) {
                prop_assert_eq!(shown, [*value; 3]);
            }
        }
    }

    #[test]
    fn a_constant_colour_is_exact_up_to_rounding(
        rgb in prop::array::uniform3(1e-3f32..1000.0),
    ) {
        for filter in FILTERS {
            // The tolerance of 16 bits is for a sum of three values of 11 bits.
            for (format, most) in [(PackedFormat::Float32, 2e-6), (PackedFormat::Float16, 1.5e-3)] {
                let error = largest_error([4, 5], [1, 0], format, filter, |_, _| rgb);
                prop_assert!(error < most, "{filter:?} {format:?}: {error}");
            }
        }
    }

    /// Exposure cancels out as long as the luminance stays above `FLOOR`.
    #[test]
    fn exposure_cancels_out(
        colors in prop::collection::vec(prop::array::uniform3(0.01f32..1.0), 36),
        stops in -6i32..10,
    ) {
        // Powers of two do not change the rounding.
        let exposure = 2f32.powi(stops);
        let color = |x: u32, y: u32| colors[(y * 6 + x) as usize];
        for filter in GUIDED_FILTERS {
            let format = PackedFormat::Float32;
            let at_one = round_trip([6, 6], [0, 0], format, filter, color);
            let exposed = round_trip([6, 6], [0, 0], format, filter, |x, y| {
                color(x, y).map(|c| c * exposure)
            });
            for (one, exposed) in at_one.into_iter().zip(exposed) {
                prop_assert_eq!(one.map(|c| c * exposure), exposed);
            }
        }
    }

    /// Luminance is stored in every pixel, so only the clamping of negative channels could change it.
    #[test]
    fn guided_filters_keep_luminance_and_give_no_negative_colour(
        colors in prop::collection::vec(prop::array::uniform3(0f32..2.0), 36),
    ) {
        let color = |x: u32, y: u32| colors[(y * 6 + x) as usize];
        for filter in GUIDED_FILTERS {
            let shown = round_trip([6, 6], [0, 0], PackedFormat::Float32, filter, color);
            for (shown, color) in shown.into_iter().zip(&colors) {
                let luminance = |c: [f32; 3]| 0.25 * c[0] + 0.5 * c[1] + 0.25 * c[2];
                prop_assert!(shown.iter().all(|c| *c >= 0.0));
                let error = (luminance(shown) - luminance(*color)).abs();
                prop_assert!(error < 1e-5, "{filter:?}: {error}");
            }
        }
    }

    /// The ratio of the missing chrominance lies within the range of the neighbours' ratios.
    #[test]
    fn guided_stays_within_the_neighbours_ratios(
        pixels in prop::array::uniform5((1e-3f32..100.0, -1f32..1.0)),
    ) {
        let [center, right, left, below, above] = pixels.map(|(y, k)| pixel(y, k * y));
        let missing = guided(center, &cross(right, left, below, above)) / center.luminance;
        let ratios = pixels[1..].iter().map(|(_, ratio)| *ratio);
        let low = ratios.clone().fold(f32::INFINITY, f32::min);
        let high = ratios.fold(f32::NEG_INFINITY, f32::max);
        prop_assert!((low - 1e-5..=high + 1e-5).contains(&missing));
    }

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

//! Results of the filters in flat areas, at edges, in noise, and with changed exposure.

use proptest::prelude::*;

use super::{FILTERS, GUIDED_FILTERS, relative_error, round_trip};
use crate::{
    reference::{
        PackedPixel,
        reconstruct::{Cross, EDGE_THRESHOLD, bilinear, edge_directed, guided, nearest},
    },
    settings::{PackedFormat, Reconstruction},
};

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
    let largest = |filter| {
        let shown = round_trip([8, 8], [0, 0], PackedFormat::Float32, filter, color);
        let errors = (0..64).map(|i| relative_error(shown[i as usize], color(i % 8, i / 8)));
        errors.fold(0.0, f32::max)
    };
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
        let shown = round_trip([10, 10], [0, 0], PackedFormat::Float32, filter, color);
        for (i, shown) in (0..100).zip(shown) {
            let error = relative_error(shown, color(i % 10, i / 10));
            assert!(error < 1e-4, "{filter:?} {i}: {shown:?}");
        }
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
        let shown = round_trip([16, 16], [0, 0], PackedFormat::Float32, filter, color);
        for (i, shown) in (0..256).zip(shown) {
            let error = relative_error(shown, color(i % 16, i / 16));
            assert!(error < 1e-5, "{filter:?} {i}: {error}");
        }
    }
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
            for shown in round_trip([4, 5], [1, 0], PackedFormat::Float32, filter, |_, _| rgb) {
                prop_assert!(relative_error(shown, rgb) < 2e-6, "{filter:?} {shown:?}");
            }
            // The tolerance is for a sum of three values of 11 bits.
            for shown in round_trip([4, 5], [1, 0], PackedFormat::Float16, filter, |_, _| rgb) {
                prop_assert!(relative_error(shown, rgb) < 1.5e-3, "{filter:?} {shown:?}");
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
}

//! Resolve of the samples of a pixel.

use proptest::prelude::*;

use crate::{
    reference::{
        PackedPixel,
        color::{linear_from_srgb, srgb_from_linear, ycocg_from_rgb},
        msaa::{mean_in_linear_light, resolved},
        pack,
    },
    settings::MsaaResolve,
};

#[test]
fn the_box_is_the_mean() {
    let samples = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|color| pack(color, 0, 0));
    let mean = resolved(&samples, MsaaResolve::Box);
    assert_eq!(mean, pack([0.5, 0.5, 0.0], 0, 0));
}

/// In a pixel that a light of 10,000 covers by half, the tone-mapped result is as bright as the light
/// with equal weights, and half as bright with the tone-mapping weights.
#[test]
fn tone_map_weights_keep_half_covered_pixels_of_a_bright_light_between_both_sides() {
    let samples = [[1e4; 3], [0.0; 3]].map(|color| pack(color, 0, 0));
    let shown = |resolve| {
        let y = resolved(&samples, resolve).luminance;
        y / (1.0 + y)
    };
    assert!(shown(MsaaResolve::Box) > 0.999);
    assert!((shown(MsaaResolve::ToneMapWeighted) - 0.5).abs() < 1e-3);
}

/// At an edge between two shades of a colour, the ratio of its chrominances to luminance is that of both.
#[test]
fn samples_of_8_bits_are_averaged_in_linear_light() {
    let encoded = [[0.8, 0.4, 0.2], [0.4, 0.2, 0.1]];
    let samples = encoded.map(|color| pack(color, 0, 0));
    let color = ycocg_from_rgb(encoded[0]);
    let mean = mean_in_linear_light(&samples, color.cg / color.y, true);
    for (channel, mean) in mean.into_iter().enumerate() {
        let linear = encoded.map(|color| linear_from_srgb(color[channel]));
        let wanted = (linear[0] + linear[1]) / 2.0;
        assert!((mean - wanted).abs() < 1e-5);
        let too_dark = (encoded[0][channel] + encoded[1][channel]) / 2.0;
        assert!(srgb_from_linear(mean) > too_dark);
    }
}

/// Samples of which some are white and the others black have the mean that their number says, for all counts that
/// adapters have.
#[test]
fn each_sample_counts_once() {
    for count in [1, 2, 4, 8, 16] {
        for white in 0..=count {
            let samples: Vec<_> = (0..count)
                .map(|i| pack([f32::from(i < white); 3], 0, 0))
                .collect();
            let share = white as f32 / count as f32;
            assert_eq!(resolved(&samples, MsaaResolve::Box).luminance, share);
            for mean in mean_in_linear_light(&samples, 0.0, true) {
                assert!((mean - share).abs() < 1e-6, "{white} of {count}: {mean}");
            }
            // White has the weight of a half, black that of one.
            let weighted = resolved(&samples, MsaaResolve::ToneMapWeighted).luminance;
            let wanted = 0.5 * white as f32 / (count as f32 - 0.5 * white as f32);
            assert!(
                (weighted - wanted).abs() < 1e-6,
                "{white} of {count}: {weighted}"
            );
        }
    }
}

#[test]
fn no_samples_are_black() {
    assert_eq!(resolved(&[], MsaaResolve::Box), PackedPixel::default());
}

proptest! {
    /// The result equals equal samples, and lies between the extremes of different ones.
    #[test]
    fn a_resolve_is_a_mean(colors in prop::collection::vec(prop::array::uniform3(0f32..1e4), 1..9)) {
        let samples: Vec<_> = colors.iter().map(|color| pack(*color, 0, 1)).collect();
        for resolve in [MsaaResolve::Box, MsaaResolve::ToneMapWeighted] {
            let same = resolved(&[samples[0]; 4], resolve);
            prop_assert!((same.luminance - samples[0].luminance).abs() <= 1e-6 * same.luminance);
            let mean = resolved(&samples, resolve);
            for value in [|p: &PackedPixel| p.luminance, |p: &PackedPixel| p.chrominance] {
                let low = samples.iter().map(value).fold(f32::INFINITY, f32::min);
                let high = samples.iter().map(value).fold(f32::NEG_INFINITY, f32::max);
                prop_assert!((low - 0.01..=high + 0.01).contains(&value(&mean)));
            }
        }
    }
}

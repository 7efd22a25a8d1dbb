//! Single pixels: the colour transform, parity, sanitizing, the storage formats, and the resolve of samples.

use proptest::prelude::*;

use crate::{
    reference::{
        pack::{
            F16_MAX, PackedPixel, YCoCg, linear_from_srgb, pack, rgb_from_ycocg, round_f16,
            round_unorm8, sanitized, srgb_from_linear, stored, stores_co,
            unorm8::{self, pack_unorm8},
            ycocg_from_rgb,
        },
        reconstruct::{mean_in_linear_light, resolved},
    },
    settings::{MsaaResolve, PackedFormat},
};

#[test]
fn primaries_have_the_chrominances_of_the_matrix() {
    let cases = [
        ([1.0, 0.0, 0.0], [0.25, 0.5, -0.25]),
        ([0.0, 1.0, 0.0], [0.5, 0.0, 0.5]),
        ([0.0, 0.0, 1.0], [0.25, -0.5, -0.25]),
        ([1.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
    ];
    for (rgb, [y, co, cg]) in cases {
        assert_eq!(ycocg_from_rgb(rgb), YCoCg { y, co, cg });
    }
}

#[test]
fn co_is_where_x_plus_y_is_even() {
    let red = [1.0, 0.0, 0.0];
    for (x, y) in [(0, 0), (1, 1), (4, 2), (7, 9), (u32::MAX, u32::MAX)] {
        assert!(stores_co(x, y));
        assert_eq!(pack(red, x, y).chrominance, 0.5);
    }
    for (x, y) in [(1, 0), (0, 1), (4, 3), (8, 9), (u32::MAX, 0)] {
        assert!(!stores_co(x, y));
        assert_eq!(pack(red, x, y).chrominance, -0.25);
    }
}

#[test]
fn invalid_colours_are_sanitized() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    assert_eq!(sanitized(odd), [0.0, F16_MAX, 0.0]);
    assert_eq!(sanitized([-1.0, 1e9, 1e-7]), [0.0, F16_MAX, 1e-7]);
}

#[test]
fn the_brightest_colours_fit_in_16_bits() {
    for rgb in [[F16_MAX; 3], [F16_MAX, 0.0, 0.0], [0.0, F16_MAX, 0.0]] {
        for x in 0..2 {
            let pixel = stored(pack(rgb, x, 0), PackedFormat::Float16);
            assert!(pixel.luminance.is_finite() && pixel.chrominance.is_finite());
        }
    }
}

#[test]
fn halves_round_to_nearest_even() {
    // Between 2048 and 4096 halves are 2 apart.
    for (value, half) in [(2049.0, 2048.0), (2051.0, 2052.0), (2050.5, 2050.0)] {
        assert_eq!(round_f16(value), half);
    }
    // A denormal half, and a value that is nearer to 0 than to the smallest one.
    assert_eq!(round_f16(1e-7), 2.0f32.powi(-23));
    assert_eq!(round_f16(2e-8), 0.0);
}

#[test]
fn bytes_round_to_nearest_and_clamp() {
    assert_eq!(round_unorm8(100.4 / 255.0), 100.0 / 255.0);
    assert_eq!(round_unorm8(100.6 / 255.0), 101.0 / 255.0);
    assert_eq!([-1.0, 2.0, f32::NAN].map(round_unorm8), [0.0, 1.0, 0.0]);
}

#[test]
fn gray_stores_exactly_the_bias_in_8_bits() {
    for x in 0..2 {
        let pixel = stored(pack_unorm8([0.37; 3], x, 0), PackedFormat::Unorm8);
        assert_eq!(pixel.chrominance, unorm8::BIAS);
        let encoded = unorm8::decoded(pixel).luminance;
        assert!((encoded - srgb_from_linear(0.37)).abs() <= 0.5 / 255.0);
    }
}

#[test]
fn steps_of_8_bits_are_small_where_they_are_seen() {
    let step = |value: f32| {
        let code = unorm8::compressed(value);
        (unorm8::expanded(code + 0.5 / 255.0) - unorm8::expanded(code - 0.5 / 255.0)) * 255.0
    };
    assert!((step(0.002) - 1.0 / 3.0).abs() < 0.01);
    assert!((step(0.366) - 1.0).abs() < 0.01);
    assert!((step(0.998) - 3.0).abs() < 0.02);
}

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
        let expected = (linear[0] + linear[1]) / 2.0;
        assert!((mean - expected).abs() < 1e-5);
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
            let fraction = white as f32 / count as f32;
            assert_eq!(resolved(&samples, MsaaResolve::Box).luminance, fraction);
            for mean in mean_in_linear_light(&samples, 0.0, true) {
                assert!((mean - fraction).abs() < 1e-6, "{white} of {count}: {mean}");
            }
            // White has the weight of a half, black that of one.
            let weighted = resolved(&samples, MsaaResolve::ToneMapWeighted).luminance;
            let expected = 0.5 * white as f32 / (count as f32 - 0.5 * white as f32);
            assert!(
                (weighted - expected).abs() < 1e-6,
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
    #[test]
    fn codes_of_8_bits_are_invertible(luminance in 0f32..1.0, chrominance in -0.5f32..0.5) {
        let pixel = PackedPixel { luminance, chrominance };
        let code = unorm8::code(pixel);
        prop_assert!((0.0..=1.0).contains(&code.luminance));
        prop_assert!((-0.002..=1.003).contains(&code.chrominance));
        let back = unorm8::decoded(code);
        prop_assert!((back.luminance - luminance).abs() < 1e-6);
        prop_assert!((back.chrominance - chrominance).abs() < 1e-6);
    }

    #[test]
    fn the_transform_is_invertible(r in 0f32..65504.0, g in 0f32..65504.0, b in 0f32..65504.0) {
        let back = rgb_from_ycocg(ycocg_from_rgb([r, g, b]));
        for (a, e) in back.into_iter().zip([r, g, b]) {
            // The tolerance is half an ulp of the largest value for each of the additions.
            prop_assert!((a - e).abs() <= 4.0 * f32::EPSILON * 65504.0);
        }
    }

    #[test]
    fn no_packed_value_exceeds_the_largest_channel(
        rgb in prop::array::uniform3(0f32..65504.0), x: u32, y: u32,
    ) {
        let pixel = pack(rgb, x, y);
        let largest = rgb.into_iter().fold(0.0, f32::max) * (1.0 + 2.0 * f32::EPSILON);
        prop_assert!(pixel.luminance <= largest && pixel.chrominance.abs() <= largest);
    }

    /// Packing commutes with blending.
    #[test]
    fn packing_is_linear(
        a in prop::array::uniform3(0f32..100.0),
        b in prop::array::uniform3(0f32..100.0),
        alpha in 0f32..1.0,
        x: u32,
        y: u32,
    ) {
        let blend = |a: f32, b: f32| alpha * a + (1.0 - alpha) * b;
        let blended = pack([0, 1, 2].map(|c| blend(a[c], b[c])), x, y);
        let [a, b] = [a, b].map(|color| pack(color, x, y));
        let expected = PackedPixel {
            luminance: blend(a.luminance, b.luminance),
            chrominance: blend(a.chrominance, b.chrominance),
        };
        prop_assert!((blended.luminance - expected.luminance).abs() < 1e-4);
        prop_assert!((blended.chrominance - expected.chrominance).abs() < 1e-4);
    }

    #[test]
    fn any_colour_packs_to_values_within_every_format(
        rgb in prop::array::uniform3(any::<f32>()), x: u32, y: u32,
    ) {
        for format in [PackedFormat::Float16, PackedFormat::Float32] {
            let pixel = stored(pack(rgb, x, y), format);
            prop_assert!((0.0..=F16_MAX).contains(&pixel.luminance));
            prop_assert!(pixel.chrominance.abs() <= F16_MAX);
        }
        let pixel = stored(pack_unorm8(rgb, x, y), PackedFormat::Unorm8);
        prop_assert!((0.0..=1.0).contains(&pixel.luminance));
        prop_assert!((0.0..=1.0).contains(&pixel.chrominance));
    }

    #[test]
    fn srgb_encoding_is_invertible(linear in 0f32..1.0) {
        prop_assert!((linear_from_srgb(srgb_from_linear(linear)) - linear).abs() < 2e-6);
    }

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

//! Results of every method on simple textures, and with extreme derivatives, coordinates, sizes and borders.

use proptest::prelude::*;

use super::{super::probes::single_probe, *};

proptest! {
    #[test]
    fn a_constant_stays_a_constant(
        log_major in -12.0..6.0f64, log_ratio in 0.0..12.0f64, angle in 0.0..3.2f64,
        u in -3.0..3.0f64, v in -3.0..3.0f64, method in 0usize..9, kernel in 0usize..5, frame in 0u32..2,
    ) {
        let color = [0.2, 0.5, 0.7, 1.0];
        let texture = Texture::from_fn([48, 20], |_, _| color);
        let major = log_major.exp2();
        let settings = EwaSettings {
            kernel: KERNELS[kernel],
            ..EwaSettings::with_method(METHODS[method])
        };
        let derivatives = ellipse(major, major / log_ratio.exp2(), angle);
        let sampled = sample(&texture, [u, v], derivatives, &settings, frame);
        for (actual, expected) in sampled.color.iter().zip(color) {
            prop_assert!((actual - expected).abs() < 1e-9, "{sampled:?}");
        }
    }

    /// Equation 5.4 is exact, for every kernel.
    #[test]
    fn linear_equals_reference(
        log_major in -8.0..2.0f64, log_ratio in 0.0..6.0f64, angle in 0.0..3.2f64,
        u in 0.0..1.0f64, v in 0.0..1.0f64, kernel in 0usize..5,
    ) {
        let texture = noise([64, 37]);
        let major = log_major.exp2();
        let derivatives = ellipse(major, major / log_ratio.exp2(), angle);
        let [reference, linear] = [EwaMethod::Reference, EwaMethod::Linear].map(|method| {
            let settings = EwaSettings {
                kernel: KERNELS[kernel],
                ..EwaSettings::with_method(method)
            };
            sample(&texture, [u, v], derivatives, &settings, 0)
        });
        prop_assert!(difference(reference.color, linear.color) < 1e-9);
        prop_assert!(linear.fetches <= reference.fetches + 1);
    }

    /// Four texels per fetch are exact where the ellipse is parallel to the axes of the texture.
    #[test]
    fn bilinear_is_exact_for_axis_aligned_ellipses(
        major in 0.02..0.3f64, ratio in 1.0..8.0f64, u in 0.0..1.0f64, v in 0.0..1.0f64,
    ) {
        let texture = noise([64, 64]);
        let derivatives = ellipse(major, major / ratio, 0.0);
        let [reference, bilinear] = [EwaMethod::Reference, EwaMethod::Bilinear]
            .map(|method| sample_by(method, &texture, [u, v], derivatives).color);
        // The tolerance is for the constant that is subtracted from the kernel: it is not separable.
        prop_assert!(difference(reference, bilinear) < 0.03);
    }

    /// A small change of the footprint changes the colour by little, for any footprint. Where the ellipse gains a row or
    /// a column at its start, `Bilinear` forms other blocks, and the error of each block is another.
    #[test]
    fn exact_methods_are_continuous_in_the_footprint(
        log_major in -8.0..3.0f64, log_ratio in 0.0..8.0f64, angle in 0.0..3.2f64,
        u in 0.0..1.0f64, v in 0.0..1.0f64, method in 0usize..3, budget in 40u32..2048,
    ) {
        let texture = noise([64, 64]);
        let settings = EwaSettings { max_fetches: budget, ..EwaSettings::with_method(EXACT[method]) };
        let at = |log_major: f64, log_ratio: f64| {
            let major = log_major.exp2();
            let derivatives = ellipse(major, major / log_ratio.exp2(), angle);
            sample(&texture, [u, v], derivatives, &settings, 0).color
        };
        let step = 1e-4;
        let change = difference(at(log_major, log_ratio), at(log_major + step, log_ratio))
            .max(difference(at(log_major, log_ratio), at(log_major, log_ratio + step)));
        let most = if EXACT[method] == EwaMethod::Bilinear { 0.03 } else { 0.01 };
        prop_assert!(change < most, "{change}");
    }
}

#[test]
fn a_magnified_texture_is_its_bilinear_reconstruction() {
    let texture = noise([16, 8]);
    for method in METHODS {
        for uv in [[0.13, 0.4], [0.99, 0.01], [-0.3, 2.7]] {
            let sampled = sample_by(method, &texture, uv, ellipse(0.02, 0.003, 0.4));
            let expected = texture.bilinear(0, [uv[0] * 16.0, uv[1] * 8.0]);
            let difference = difference(sampled.color, expected);
            assert!(difference < 0.05, "{method:?} at {uv:?}: {difference}");
        }
    }
}

#[test]
fn the_mean_of_two_temporal_frames_is_approximate() {
    let texture = noise([128, 128]);
    for i in 0..50 {
        let t = f64::from(i) / 50.0;
        let derivatives = ellipse(0.02 + 0.2 * t, 0.01, 3.0 * t);
        let uv = [t, 0.3 + 7.0 * t];
        for probes in [
            EwaProbes::Three,
            FIVE,
            EwaProbes::Seven,
            EwaProbes::ByAspect,
        ] {
            let at = |method, frame| {
                let settings = EwaSettings::with_method(method);
                sample(&texture, uv, derivatives, &settings, frame)
            };
            let both = at(EwaMethod::Approximate { probes }, 0);
            let [even, odd] = [0, 1].map(|frame| at(EwaMethod::Temporal { probes }, frame));
            assert!(even.fetches <= both.fetches && odd.fetches <= both.fetches);
            for channel in 0..4 {
                let mean = (even.color[channel] + odd.color[channel]) / 2.0;
                let expected = both.color[channel];
                // With five probes, those of odd index have a fiftieth more than half of the total
                // weight.
                assert!(
                    (mean - expected).abs() < 0.02,
                    "{probes:?}: {mean} {expected}"
                );
            }
        }
    }
}

#[test]
fn spatial_is_one_probe_below_the_threshold_and_approximate_above() {
    let texture = noise([256, 256]);
    let derivatives = |anisotropy: f64| ellipse(0.1, 0.1 / anisotropy, 0.7);
    let at = |method, anisotropy| sample_by(method, &texture, [0.3, 0.6], derivatives(anisotropy));
    let one = |anisotropy| {
        let footprint = Footprint::new(derivatives(anisotropy), [256, 256], 32.0);
        texture.take_fetches();
        Sampled {
            color: single_probe(&texture, &footprint, [0.3, 0.6], &EwaSettings::default()),
            fetches: texture.take_fetches(),
        }
    };
    let spatial = EwaMethod::Spatial { probes: FIVE };
    let approximate = EwaMethod::Approximate { probes: FIVE };
    for anisotropy in [1.0, 4.0, 14.9] {
        assert_eq!(at(spatial, anisotropy), one(anisotropy), "{anisotropy}");
    }
    for anisotropy in [16.1, 40.0] {
        let expected = at(approximate, anisotropy);
        assert_eq!(at(spatial, anisotropy), expected, "{anisotropy}");
    }
    let [low, between, high] = [one(15.5), at(spatial, 15.5), at(approximate, 15.5)];
    for channel in 0..4 {
        let mean = (low.color[channel] + high.color[channel]) / 2.0;
        assert!((between.color[channel] - mean).abs() < 1e-6);
    }
}

/// A texture unit that gets the derivatives takes the footprint of two diagonal ones for a square; with
/// the axes of the ellipse it does not.
#[test]
fn the_single_probe_depends_only_on_the_ellipse() {
    let texture = noise([256, 256]);
    let spatial = EwaMethod::Spatial { probes: FIVE };
    let axes = ellipse(0.1, 0.02, 0.7);
    let expected = sample_by(spatial, &texture, [0.3, 0.6], axes).color;
    for rotation in [0.3, 0.785, 2.0] {
        let actual = sample_by(spatial, &texture, [0.3, 0.6], rotated(axes, rotation)).color;
        assert!(difference(actual, expected) < 1e-9, "{rotation}");
    }
}

#[test]
fn every_method_preserves_a_linear_ramp() {
    // A symmetric filter preserves the value of a linear ramp.
    let texture = Texture::from_fn([256, 256], |x, y| {
        [f64::from(x) / 256.0, f64::from(y) / 256.0, 0.0, 1.0]
    });
    for method in METHODS {
        if matches!(method, EwaMethod::Hardware) {
            continue;
        }
        for angle in [0.0, 0.6, 1.2, 2.0, 2.8] {
            let sampled = sample_by(method, &texture, [0.5, 0.5], ellipse(0.1, 0.02, angle));
            for channel in 0..2 {
                let value = sampled.color[channel];
                let expected = 0.5 - 0.5 / 256.0;
                assert!(
                    (value - expected).abs() < 0.004,
                    "{method:?} {angle}: {value}"
                );
            }
        }
    }
}

const ADDRESSES: [AddressMode; 4] = [
    AddressMode::Repeat,
    AddressMode::MirrorRepeat,
    AddressMode::ClampToEdge,
    AddressMode::ClampToBorder,
];

fn is_color(sampled: Sampled) -> bool {
    let range = -0.5..=1.5;
    sampled.fetches < 5000 && sampled.color.iter().all(|c| range.contains(c))
}

#[test]
fn no_derivative_breaks_any_method() {
    let values = [
        [0.0, -0.0, 1e-300, 1e-30, 1e-6, 0.1, -0.1].as_slice(),
        &[3.0, 1e6, 1e30, f64::MAX],
        &[f64::INFINITY, f64::NEG_INFINITY, f64::NAN],
    ]
    .concat();
    let texture = noise([32, 16]);
    for method in METHODS {
        let settings = EwaSettings::with_method(method);
        for (i, &a) in values.iter().enumerate() {
            for &b in &values {
                let c = values[(i * 5 + 3) % values.len()];
                // Linearly dependent derivatives have a line as their footprint.
                for dy in [[c, a], [a, b], [0.0, 0.0]] {
                    let derivatives = Derivatives { dx: [a, b], dy };
                    let sampled = sample(&texture, [0.4, 0.7], derivatives, &settings, 1);
                    assert!(is_color(sampled), "{method:?} {derivatives:?}: {sampled:?}");
                }
            }
        }
    }
}

#[test]
fn a_footprint_of_the_whole_texture_gives_its_mean() {
    let texture = noise([32, 16]);
    let mean = texture.levels[5].texels[0];
    for method in METHODS {
        for derivative in [f64::INFINITY, 1e20, 1e4] {
            let derivatives = ellipse(derivative, derivative, 0.0);
            let sampled = sample_by(method, &texture, [0.4, 0.7], derivatives);
            for (actual, expected) in sampled.color.iter().zip(mean) {
                assert!((actual - expected).abs() < 1e-6, "{method:?} {derivative}");
            }
        }
    }
}

#[test]
fn no_setting_breaks_any_method() {
    let texture = noise([32, 16]);
    for value in [f32::NAN, f32::INFINITY, -f32::INFINITY, -3.0, 0.0, 1e9] {
        for method in METHODS {
            let settings = EwaSettings {
                kernel: EwaKernel::Gaussian {
                    sigma_pixels: value,
                },
                max_anisotropy: value,
                minor_radius_texels: value,
                level_blend: value,
                max_fetches: value as u32,
                spatial_threshold: value,
                sampler_anisotropy: value as u16,
                ..EwaSettings::with_method(method)
            };
            let derivatives = ellipse(0.5, 0.01, 1.0);
            let sampled = sample(&texture, [0.4, 0.7], derivatives, &settings, 0);
            assert!(is_color(sampled), "{method:?} {value}: {sampled:?}");
        }
    }
}

#[test]
fn large_coordinates_repeat_the_first_period() {
    let derivatives = ellipse(0.05, 0.01, 0.8);
    for address in [AddressMode::Repeat, AddressMode::MirrorRepeat] {
        let texture = noise([1024, 64]).with_address([address; 2]);
        for method in METHODS {
            let near = sample_by(method, &texture, [0.375, 0.25], derivatives).color;
            for far in [1e4, -1e4, 9998.0] {
                let uv = [0.375 + far, 0.25 - far];
                let difference =
                    difference(sample_by(method, &texture, uv, derivatives).color, near);
                assert!(difference < 1e-6, "{method:?} {address:?} {far}");
            }
        }
    }
    for uv in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300] {
        for address in ADDRESSES {
            let texture = noise([64, 32]).with_address([address; 2]);
            for method in METHODS {
                let sampled = sample_by(method, &texture, [uv, 0.3], derivatives);
                assert!(is_color(sampled), "{method:?} {uv}: {sampled:?}");
            }
        }
    }
}

#[test]
fn every_size_down_to_one_texel() {
    for size in [[1, 1], [1, 7], [5, 1], [2, 3], [33, 17], [8192, 2]] {
        let texture = noise(size);
        for method in METHODS {
            for (major, minor) in [(1e-4, 1e-5), (0.3, 0.02), (5.0, 0.1)] {
                let derivatives = ellipse(major, minor, 0.5);
                let sampled = sample_by(method, &texture, [0.9, 0.2], derivatives);
                assert!(is_color(sampled), "{method:?} {size:?}: {sampled:?}");
                if size == [1, 1] {
                    let texel = texture.levels[0].texels[0];
                    assert!(difference(sampled.color, texel) < 1e-9);
                }
            }
        }
    }
}

#[test]
fn borders_follow_the_address_mode() {
    // A texture that is laid out explicitly as its address mode would, filtered in its middle, gives the
    // same result as the texture itself at its border.
    let size = 32u32;
    let small = noise([size, size]);
    let derivatives = ellipse(0.1, 0.04, 0.6);
    for address in ADDRESSES {
        let texture = small.clone().with_address([address; 2]);
        let levels = small.levels.iter().map(|level| {
            let n = level.size[0];
            let at = |x: u32, y: u32| {
                let shifted = [x, y].map(|i| i64::from(i) - i64::from(4 * n));
                let x = address.wrap(shifted[0], n);
                let y = address.wrap(shifted[1], n);
                match (x, y) {
                    (Some(x), Some(y)) => level.texels[(y * n + x) as usize],
                    _ => [0.0; 4],
                }
            };
            let all = (0..8 * n).flat_map(|y| (0..8 * n).map(move |x| (x, y)));
            Level {
                size: [8 * n; 2],
                texels: all.map(|(x, y)| at(x, y)).collect(),
            }
        });
        let laid_out = Texture::from_levels(levels.collect(), [AddressMode::Repeat; 2]);
        for method in METHODS {
            for uv in [[0.0, 0.5], [1.0, 0.02], [0.5, 0.0], [-0.03, 1.04]] {
                let at_border = sample_by(method, &texture, uv, derivatives).color;
                let in_the_middle = uv.map(|c| (c + 4.0) / 8.0);
                let eighth = Derivatives {
                    dx: derivatives.dx.map(|d| d / 8.0),
                    dy: derivatives.dy.map(|d| d / 8.0),
                };
                let middle = sample_by(method, &laid_out, in_the_middle, eighth).color;
                let difference = difference(at_border, middle);
                assert!(difference < 1e-9, "{method:?} {address:?} {uv:?}");
            }
        }
    }
}

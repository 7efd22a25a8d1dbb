//! Extreme derivatives, coordinates, sizes and borders.

use super::{super::sample::sample, *};

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
        0.0,
        -0.0,
        1e-300,
        1e-30,
        1e-6,
        0.1,
        -0.1,
        3.0,
        1e6,
        1e30,
        f64::MAX,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];
    let texture = noise([32, 16]);
    for method in METHODS {
        let settings = EwaSettings::with_method(method);
        for (i, a) in values.iter().enumerate() {
            for b in values {
                let c = values[(i * 5 + 3) % values.len()];
                for derivatives in [
                    Derivatives {
                        dx: [*a, b],
                        dy: [c, *a],
                    },
                    // Linearly dependent derivatives, whose footprint is a line.
                    Derivatives {
                        dx: [*a, b],
                        dy: [*a, b],
                    },
                    Derivatives {
                        dx: [*a, b],
                        dy: [0.0, 0.0],
                    },
                ] {
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
            let settings = EwaSettings::with_method(method);
            let sampled = sample(&texture, [0.4, 0.7], derivatives, &settings, 0);
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
            let settings = EwaSettings::with_method(method);
            let near = sample(&texture, [0.375, 0.25], derivatives, &settings, 0);
            for far in [1e4, -1e4, 9998.0] {
                let uv = [0.375 + far, 0.25 - far];
                let actual = sample(&texture, uv, derivatives, &settings, 0);
                assert!(
                    difference(actual, near) < 1e-6,
                    "{method:?} {address:?} {far}"
                );
            }
        }
    }
    for uv in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300] {
        for address in ADDRESSES {
            let texture = noise([64, 32]).with_address([address; 2]);
            for method in METHODS {
                let settings = EwaSettings::with_method(method);
                assert!(is_color(sample(
                    &texture,
                    [uv, 0.3],
                    derivatives,
                    &settings,
                    0
                )));
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
                let settings = EwaSettings::with_method(method);
                let derivatives = ellipse(major, minor, 0.5);
                let sampled = sample(&texture, [0.9, 0.2], derivatives, &settings, 0);
                assert!(is_color(sampled), "{method:?} {size:?}: {sampled:?}");
                if size == [1, 1] {
                    let texel = texture.levels[0].texels[0];
                    let expected = Sampled {
                        color: texel,
                        fetches: 0,
                    };
                    assert!(difference(sampled, expected) < 1e-9);
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
            let settings = EwaSettings::with_method(method);
            for uv in [[0.0, 0.5], [1.0, 0.02], [0.5, 0.0], [-0.03, 1.04]] {
                let at_border = sample(&texture, uv, derivatives, &settings, 0);
                let in_the_middle = uv.map(|c| (c + 4.0) / 8.0);
                let eighth = Derivatives {
                    dx: derivatives.dx.map(|d| d / 8.0),
                    dy: derivatives.dy.map(|d| d / 8.0),
                };
                let middle = sample(&laid_out, in_the_middle, eighth, &settings, 0);
                assert!(
                    difference(at_border, middle) < 1e-9,
                    "{method:?} {address:?} {uv:?}"
                );
            }
        }
    }
}

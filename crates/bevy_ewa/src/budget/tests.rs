//! Budgets hold, and a larger budget never gives a larger error.

use proptest::prelude::*;

use super::*;
use crate::{
    EwaKernel, EwaLevelOfDetail, EwaMethod,
    mips::texel::srgb_from_linear,
    reference::{Derivatives, Texture, sample, scenes::Surface},
};

const SIZE: u32 = 48;

/// The surfaces of the study, all with a checkerboard texture.
fn surfaces() -> Vec<Surface> {
    let plane = |grazing: f64, half_fov: f64, rotation: f64, scale: f64| Surface::Plane {
        grazing_angle: grazing.to_radians(),
        tan_half_fov: half_fov.to_radians().tan(),
        rotation: rotation.to_radians(),
        scale,
        camera_position: 0.0,
    };
    let tunnel = Surface::Tunnel {
        tan_half_fov: 1.0,
        around: 4.0,
        along: 0.5,
        camera_position: 0.0,
    };
    vec![
        tunnel,
        plane(1.0, 0.5, 0.0, 0.5),
        plane(5.0, 3.0, 0.0, 1.0),
        plane(5.0, 3.0, 45.0, 1.0),
        plane(8.0, 5.0, 15.0, 0.4),
        plane(5.0, 3.0, 30.0, 0.5),
        plane(15.0, 12.0, 20.0, 0.5),
    ]
}

fn checks() -> Texture {
    Texture::from_fn([256, 256], |x, y| {
        let bright = (x / 32 + y / 32) % 2 == 0;
        let v = if bright { 0.9 } else { 0.02 };
        [v, v, v, 1.0]
    })
}

/// Returns the picture in 8-bit sRGB and the mean fetches per pixel.
fn picture(surface: &Surface, texture: &Texture, settings: &EwaSettings) -> (Vec<f64>, f64) {
    let (mut values, mut fetches) = (Vec::new(), 0);
    // `SoftwareAnisotropic` stands for the filter of the texture unit, which the CPU reference lacks.
    let is_texture_unit = settings.method == EwaMethod::Anisotropic;
    let settings = EwaSettings {
        method: if is_texture_unit {
            EwaMethod::SoftwareAnisotropic
        } else {
            settings.method
        },
        ..*settings
    };
    for i in 0..SIZE * SIZE {
        let (uv, derivatives) = surface.pixel(SIZE, [i % SIZE, i / SIZE]);
        let sampled = sample(texture, uv, derivatives, &settings, 0);
        let value = srgb_from_linear(sampled.color[0].clamp(0.0, 1.0) as f32);
        values.push(f64::from((value * 255.0).round()));
        fetches += if is_texture_unit { 1 } else { sampled.fetches };
    }
    (values, f64::from(fetches) / f64::from(SIZE * SIZE))
}

#[test]
fn the_table_has_the_measured_errors_and_costs() {
    let (surfaces, texture) = (surfaces(), checks());
    let exact = EwaSettings::with_method(EwaMethod::Reference);
    let expected: Vec<_> = surfaces
        .iter()
        .map(|surface| picture(surface, &texture, &exact).0)
        .collect();
    let mut wrong = Vec::new();
    for candidate in &CANDIDATES {
        let measured = [1, 16].map(|sampler_anisotropy| {
            let settings = candidate.settings(EwaSettings {
                sampler_anisotropy,
                ..EwaSettings::default()
            });
            let (mut error, mut most) = (0.0, 0.0f64);
            for (surface, expected) in surfaces.iter().zip(&expected) {
                let (values, fetches) = picture(surface, &texture, &settings);
                let squares = values.iter().zip(expected).map(|(a, b)| (a - b).powi(2));
                error += squares.sum::<f64>() / values.len() as f64 / surfaces.len() as f64;
                most = most.max(fetches);
            }
            (error as f32, most as f32)
        });
        println!(
            "{:?} {} {}",
            candidate.method, candidate.max_anisotropy, candidate.max_fetches
        );
        println!(
            "    [{:.1}, {:.1}], [{:.1}, {:.1}]",
            measured[0].0, measured[1].0, measured[0].1, measured[1].1
        );
        for (i, (error, fetches)) in measured.into_iter().enumerate() {
            // The tolerance is half of the last digit in the table.
            if (candidate.errors[i] - error).abs() > 0.051
                || (candidate.fetches[i] - fetches).abs() > 0.051
            {
                wrong.push(candidate.method);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Returns the mean fetches per pixel of the scene that takes most.
fn mean_fetches_of_the_costliest_scene(settings: &EwaSettings) -> f64 {
    let texture = checks();
    let surfaces = surfaces();
    let fetches = surfaces
        .iter()
        .map(|surface| picture(surface, &texture, settings).1);
    fetches.fold(0.0, f64::max)
}

#[test]
fn pictures_keep_within_their_budget() {
    for sampler_anisotropy in [1, 16] {
        let base = EwaSettings {
            sampler_anisotropy,
            ..EwaSettings::default()
        };
        for fetches in [
            1.0, 2.0, 4.9, 6.0, 15.0, 24.0, 49.0, 55.0, 80.0, 150.0, 300.0,
        ] {
            let settings = EwaBudget { fetches }.fit_mean(base);
            let fetches_per_pixel = mean_fetches_of_the_costliest_scene(&settings);
            let allowed = f64::from(fetches) + 0.05;
            assert!(
                fetches_per_pixel <= allowed,
                "{fetches_per_pixel} of {fetches}: {settings:?}"
            );
        }
    }
}

/// Returns the error of the chosen settings from the table.
fn error(settings: &EwaSettings) -> f32 {
    let candidate = CANDIDATES
        .iter()
        .find(|candidate| candidate.settings(*settings) == *settings);
    candidate
        .expect("a candidate")
        .error(settings.sampler_anisotropy)
}

#[test]
fn a_larger_budget_never_has_a_larger_error() {
    for sampler_anisotropy in [1, 16] {
        let base = EwaSettings {
            sampler_anisotropy,
            ..EwaSettings::default()
        };
        let (mut mean, mut worst) = (f32::INFINITY, f32::INFINITY);
        for step in 0..400 {
            let budget = EwaBudget {
                fetches: 1.03f32.powi(step),
            };
            let next = [budget.fit_mean(base), budget.fit_worst_case(base)].map(|s| error(&s));
            assert!(next[0] <= mean && next[1] <= worst, "{budget:?}: {next:?}");
            [mean, worst] = next;
        }
        // The largest budgets choose an exact method.
        assert!(mean < 0.1 && worst < 0.1, "{mean} {worst}");
    }
}

#[test]
fn a_smaller_error_never_costs_less_and_is_kept() {
    for sampler_anisotropy in [1, 16] {
        let base = EwaSettings {
            sampler_anisotropy,
            ..EwaSettings::default()
        };
        let mut last = 0.0;
        for bound in [
            1e6,
            100.0,
            98.0,
            30.0,
            10.0,
            5.0,
            1.0,
            0.15,
            0.0,
            -1.0,
            f32::NAN,
        ] {
            let settings = EwaErrorBound {
                mean_squared_error: bound,
            }
            .fit(base);
            let is_chosen = |c: &&Candidate| c.settings(base) == settings;
            let candidate = CANDIDATES.iter().find(is_chosen).expect("a candidate");
            assert!(candidate.error(sampler_anisotropy) <= bound.max(0.0));
            let fetches = candidate.mean_fetches(sampler_anisotropy);
            assert!(fetches >= last, "{bound}: {settings:?}");
            last = fetches;
        }
    }
    let exact = EwaErrorBound {
        mean_squared_error: 0.0,
    };
    assert_eq!(exact.fit(EwaSettings::default()).method, EwaMethod::Linear);
}

#[test]
fn an_invalid_budget_counts_as_one_fetch() {
    for fetches in [f32::NAN, f32::NEG_INFINITY, -3.0, 0.0, 1.0] {
        let budget = EwaBudget { fetches };
        let base = EwaSettings::default();
        assert_eq!(budget.fit_mean(base).method, EwaMethod::Anisotropic);
        assert_eq!(budget.fit_worst_case(base).method, EwaMethod::Anisotropic);
    }
    let fetches = f32::INFINITY;
    let settings = EwaBudget { fetches }.fit_worst_case(EwaSettings::default());
    assert_eq!(settings.method, EwaMethod::Linear);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn no_lookup_exceeds_the_worst_case(
        log_major in -6.0..3.0f64, log_ratio in 0.0..8.0f64, angle in 0.0..3.2f64,
        rotation in 0.0..3.2f64, u in 0.0..1.0f64, v in 0.0..1.0f64,
        budget in 1.0..1200.0f32, sampler in 0usize..2, kernel in 0usize..5, hardware in any::<bool>(),
        minor_radius_texels in 0.5..4.0f32, blend in 0.0..1.0f32, threshold in 2.0..40.0f32,
    ) {
        let base = EwaSettings {
            sampler_anisotropy: [1, 16][sampler],
            kernel: [
                EwaKernel::Box,
                EwaKernel::Tent,
                EwaKernel::Gaussian { sigma_pixels: 0.7 },
                EwaKernel::MitchellNetravali,
                EwaKernel::Lanczos,
            ][kernel],
            level_of_detail: if hardware {
                EwaLevelOfDetail::Hardware
            } else {
                EwaLevelOfDetail::MinorRadius
            },
            minor_radius_texels,
            level_blend: blend,
            spatial_threshold: threshold,
            ..EwaSettings::default()
        };
        let settings = EwaBudget { fetches: budget }.fit_worst_case(base);
        let texture = checks();
        let major = log_major.exp2();
        let (axes, minor) = ([angle.cos(), angle.sin()], major / log_ratio.exp2());
        let (a, b) = ([major * axes[0], major * axes[1]], [-minor * axes[1], minor * axes[0]]);
        let mixed = |s: f64, t: f64| [0, 1].map(|i| s * a[i] + t * b[i]);
        let derivatives = Derivatives {
            dx: mixed(rotation.cos(), rotation.sin()),
            dy: mixed(-rotation.sin(), rotation.cos()),
        };
        let sampled = sample(&texture, [u, v], derivatives, &settings, 0);
        let most = worst_case_fetches(&settings);
        prop_assert!(most <= budget.max(1.0));
        // The texture unit's own filter counts as one fetch; the reference computes it with more.
        if settings.method != EwaMethod::Anisotropic {
            prop_assert!(sampled.fetches as f32 <= most, "{sampled:?} of {most}: {settings:?}");
        }
    }
}

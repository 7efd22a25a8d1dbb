//! Settings by their cost or by their error.
//!
//! The unit is the texture fetch: of one texel, bilinear, trilinear or, when the sampler's
//! `anisotropy_clamp` is above 1, anisotropic. The number of fetches does not depend on the machine.

use std::f64::consts::FRAC_1_SQRT_2;

#[cfg(feature = "bevy")]
use bevy::prelude::*;

use crate::{
    reference::{
        footprint::{Footprint, max_texels},
        probes::{self, Probe},
    },
    settings::{EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings},
};

/// A number of texture fetches per lookup, from which the most accurate settings within it follow.
///
/// ```
/// use bevy_ewa::{EwaBudget, EwaMethod, EwaSettings};
///
/// let cheap = EwaBudget { fetches: 3.0 }.fit_mean(EwaSettings::default());
/// assert_eq!(cheap.method, EwaMethod::Anisotropic);
/// let exact = EwaBudget { fetches: 250.0 }.fit_mean(EwaSettings::default());
/// assert_eq!(exact.method, EwaMethod::Linear);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq))]
pub struct EwaBudget {
    /// Texture fetches per lookup. At least 1, which is the texture unit's own filter; NaN counts as 1.
    /// Default 32.
    pub fetches: f32,
}

impl Default for EwaBudget {
    fn default() -> Self {
        Self { fetches: 32.0 }
    }
}

impl From<EwaBudget> for EwaSettings {
    /// Returns [`EwaBudget::fit_mean`] of the default settings.
    fn from(budget: EwaBudget) -> Self {
        budget.fit_mean(Self::default())
    }
}

impl EwaBudget {
    /// Returns the most accurate settings whose mean over a picture keeps within the budget on each of
    /// the study's scenes: floors that fill the picture at 1 to 15 degrees, and a tunnel. Single pixels
    /// may take more.
    ///
    /// All settings other than `method`, `max_anisotropy` and `max_fetches` are taken from `base`. The
    /// costs are those of the default kernel and minor radius.
    pub fn fit_mean(self, base: EwaSettings) -> EwaSettings {
        self.choose(base, |candidate, settings| {
            candidate.mean_fetches(settings.sampler_anisotropy)
        })
    }

    /// Returns the most accurate settings of which no single lookup exceeds the budget.
    ///
    /// `base` is used as in [`EwaBudget::fit_mean`], but the bound holds for any kernel and minor radius.
    pub fn fit_worst_case(self, base: EwaSettings) -> EwaSettings {
        self.choose(base, |_, settings| worst_case_fetches(settings))
    }

    fn choose(
        self,
        base: EwaSettings,
        cost: impl Fn(&Candidate, &EwaSettings) -> f32,
    ) -> EwaSettings {
        let fetches = self.fetches.max(1.0);
        let fits = |candidate: &&Candidate| cost(candidate, &candidate.settings(base)) <= fetches;
        let error = |candidate: &Candidate| candidate.error(base.sampler_anisotropy);
        let fitting = CANDIDATES.iter().filter(fits);
        let best = fitting.min_by(|a, b| error(a).total_cmp(&error(b)));
        // The texture unit's own filter is one fetch and always fits.
        best.map_or(base, |candidate| candidate.settings(base))
    }
}

/// A limit of the error, from which the cheapest settings within it follow.
///
/// ```
/// use bevy_ewa::{EwaErrorBound, EwaMethod, EwaSettings};
///
/// let bound = EwaErrorBound { mean_squared_error: 1.0 };
/// assert_eq!(bound.fit(EwaSettings::default()).method, EwaMethod::Bilinear);
/// let coarse = EwaErrorBound { mean_squared_error: 200.0 };
/// assert_eq!(coarse.fit(EwaSettings::default()).method, EwaMethod::Anisotropic);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq))]
pub struct EwaErrorBound {
    /// Mean squared error against exact EWA in 8-bit sRGB units, averaged over the study's scenes. NaN and numbers
    /// below 0 count as 0. Default 10.
    pub mean_squared_error: f32,
}

impl Default for EwaErrorBound {
    fn default() -> Self {
        Self {
            mean_squared_error: 10.0,
        }
    }
}

impl EwaErrorBound {
    /// Returns the settings with the fewest fetches in the mean of a picture among those within the error. All
    /// settings other than `method`, `max_anisotropy` and `max_fetches` are taken from `base`.
    pub fn fit(self, base: EwaSettings) -> EwaSettings {
        let bound = self.mean_squared_error.max(0.0);
        let anisotropy = base.sampler_anisotropy;
        let within = CANDIDATES
            .iter()
            .filter(|candidate| candidate.error(anisotropy) <= bound);
        let cheapest = within.min_by(|a, b| {
            let fetches = a
                .mean_fetches(anisotropy)
                .total_cmp(&b.mean_fetches(anisotropy));
            fetches.then(a.error(anisotropy).total_cmp(&b.error(anisotropy)))
        });
        // The exact method has the error 0 and is always within it.
        cheapest.map_or(base, |candidate| candidate.settings(base))
    }
}

/// A candidate with its measured error and cost. A test repeats the measurements
/// (`cargo test -p bevy_ewa --no-default-features --lib budget -- --nocapture` prints the rows).
///
/// The two figures of a pair are for samplers without anisotropy, where the shader computes the probes,
/// and with 16x, where they are the texture unit's, modelled by [`EwaMethod::SoftwareAnisotropic`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Value of [`EwaSettings::method`].
    pub method: EwaMethod,
    /// Value of [`EwaSettings::max_anisotropy`].
    pub max_anisotropy: f32,
    /// Value of [`EwaSettings::max_fetches`].
    pub max_fetches: u32,
    /// Mean squared error against exact EWA in 8-bit sRGB units, averaged over the scenes.
    pub errors: [f32; 2],
    /// Mean fetches per pixel in the scene that takes most.
    pub fetches: [f32; 2],
}

impl Candidate {
    /// Returns `base` with the values of this candidate.
    pub fn settings(&self, base: EwaSettings) -> EwaSettings {
        EwaSettings {
            method: self.method,
            max_anisotropy: self.max_anisotropy,
            max_fetches: self.max_fetches,
            ..base
        }
    }

    /// Returns the error on samplers of this anisotropy.
    pub fn error(&self, sampler_anisotropy: u16) -> f32 {
        self.errors[index(sampler_anisotropy)]
    }

    /// Returns the mean fetches per pixel on samplers of this anisotropy.
    pub fn mean_fetches(&self, sampler_anisotropy: u16) -> f32 {
        self.fetches[index(sampler_anisotropy)]
    }
}

fn index(sampler_anisotropy: u16) -> usize {
    usize::from(sampler_anisotropy > 1)
}

const fn candidate(
    method: EwaMethod,
    max_fetches: u32,
    errors: [f32; 2],
    fetches: [f32; 2],
) -> Candidate {
    Candidate {
        method,
        max_anisotropy: 32.0,
        max_fetches,
        errors,
        fetches,
    }
}

/// The candidates: exact methods, down to coarse mip levels, and probes.
pub const CANDIDATES: [Candidate; 19] = {
    use EwaMethod::{Anisotropic, Approximate, Bilinear, Linear, SoftwareAnisotropic, Spatial};
    use EwaProbes::{ByAspect, Five, Seven, Three};
    [
        candidate(Linear, 2048, [0.0; 2], [199.3; 2]),
        candidate(Linear, 1024, [0.2; 2], [104.6; 2]),
        candidate(Linear, 512, [2.1; 2], [51.3; 2]),
        candidate(Linear, 256, [12.7; 2], [25.1; 2]),
        candidate(Linear, 128, [58.5; 2], [12.2; 2]),
        candidate(Linear, 64, [225.9; 2], [5.5; 2]),
        candidate(Bilinear, 2048, [0.1; 2], [127.9; 2]),
        candidate(Bilinear, 1024, [1.0; 2], [63.1; 2]),
        candidate(Bilinear, 512, [3.8; 2], [32.5; 2]),
        candidate(Bilinear, 256, [12.8; 2], [16.3; 2]),
        candidate(Bilinear, 128, [68.2; 2], [8.0; 2]),
        candidate(Approximate { probes: Seven }, 2048, [4.4; 2], [56.0, 7.0]),
        candidate(Approximate { probes: Five }, 2048, [7.8; 2], [50.0, 5.0]),
        candidate(Approximate { probes: Three }, 2048, [25.3; 2], [45.0, 3.0]),
        candidate(
            Approximate { probes: ByAspect },
            2048,
            [9.3; 2],
            [54.0, 9.0],
        ),
        candidate(Spatial { probes: Five }, 2048, [32.7; 2], [50.0, 5.0]),
        candidate(Spatial { probes: Three }, 2048, [37.5; 2], [45.0, 3.0]),
        candidate(SoftwareAnisotropic, 2048, [98.1; 2], [16.0; 2]),
        candidate(Anisotropic, 2048, [98.1; 2], [1.0; 2]),
    ]
};

/// Returns the number of texture fetches that no lookup with these settings exceeds, for any derivatives.
pub fn worst_case_fetches(settings: &EwaSettings) -> f32 {
    let settings = settings.clamped();
    let max_aspect = f64::from(settings.max_anisotropy);
    let threshold = f64::from(settings.spatial_threshold);
    let fetches = match settings.method {
        EwaMethod::Reference | EwaMethod::Linear | EwaMethod::Bilinear => exact_fetches(&settings),
        EwaMethod::Approximate { probes } | EwaMethod::Temporal { probes } => {
            approximate(&settings, probes, max_aspect)
        }
        // In the blend around the threshold, both are fetched.
        EwaMethod::Spatial { probes } | EwaMethod::SpatialTemporal { probes } => {
            let single = ellipse(threshold.min(max_aspect));
            let single = Probe::single(&single, &settings).fetches();
            let blended = single + approximate(&settings, probes, threshold.min(max_aspect));
            blended.max(approximate(&settings, probes, max_aspect))
        }
        EwaMethod::SoftwareAnisotropic => probes::MAX_TAPS,
        EwaMethod::Stochastic | EwaMethod::Anisotropic | EwaMethod::Hardware => 1.0,
    };
    fetches as f32
}

/// The texels of an ellipse with the longest axes, in the finer and the coarser level that are
/// blended, or `max_fetches` if that is lower, as it raises the level of detail.
fn exact_fetches(settings: &EwaSettings) -> f64 {
    // The additional fetch is the bilinear one that magnification blends in.
    let bound = f64::from(settings.max_fetches) + 1.0;
    let minor = f64::from(settings.minor_radius_texels);
    let levels: &[f64] = if settings.level_blend > 0.0 {
        &[2.0, 1.0]
    } else {
        &[2.0]
    };
    // The formula of texture units divides by their number of taps, which can choose a finer level than
    // the loop below assumes.
    if settings.level_of_detail != EwaLevelOfDetail::MinorRadius {
        return bound;
    }
    // Pairs of texels with one negative weight are fetched one by one.
    let has_negative_lobes = matches!(
        settings.kernel,
        EwaKernel::Lanczos | EwaKernel::MitchellNetravali
    );
    let pairs = settings.method == EwaMethod::Linear && !has_negative_lobes;
    let mut fetches = 1.0;
    for level in levels {
        let minor = level * minor;
        let major = f64::from(settings.max_anisotropy) * minor;
        let texels = max_texels(major + 1.0, minor + 1.0);
        // A row of an odd number of texels has one that is fetched alone. Rows run along the longer side
        // of the bounding box, so there are most of them where its sides are equal.
        let rows = 2.0 * (FRAC_1_SQRT_2 * major.hypot(minor)).hypot(1.0) + 1.0;
        fetches += if pairs { (texels + rows) / 2.0 } else { texels };
    }
    fetches.min(bound)
}

/// The most fetches of `Approximate` for ellipses up to this aspect. Where probes are computed, the taps
/// per probe grow with the aspect until the ellipse gets another pair of probes.
fn approximate(settings: &EwaSettings, probes: EwaProbes, aspect: f64) -> f64 {
    let multiples = (1..).map(|multiple| f64::from(multiple) * probes::ASPECT_PER_PROBE_PAIR);
    let maxima = multiples.take_while(|end| *end < aspect).chain([aspect]);
    let fetches = maxima.map(|aspect| {
        let count = probes::probe_count(probes, aspect);
        f64::from(count) * Probe::new(&ellipse(aspect), settings, count).fetches()
    });
    fetches.fold(0.0, f64::max)
}

/// An ellipse so large that no probe has fewer taps because its width is limited to one texel.
fn ellipse(aspect: f64) -> Footprint {
    Footprint {
        major_radius_texels: 1e3 * aspect,
        minor_radius_texels: 1e3,
        major_direction: [1.0, 0.0],
        anisotropy: aspect,
        hardware_lod: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{
        mips::texel::srgb_from_linear,
        reference::{
            Texture, sample,
            scenes::Surface,
            tests::{KERNELS, TUNNEL, checks, ellipse, plane, rotated},
        },
    };

    const SIZE: u32 = 48;

    /// The surfaces of the study, all with a checkerboard texture.
    fn surfaces() -> [Surface; 7] {
        [
            TUNNEL,
            plane(1.0, 0.5, 0.0, 0.5),
            plane(5.0, 3.0, 0.0, 1.0),
            plane(5.0, 3.0, 45.0, 1.0),
            plane(8.0, 5.0, 15.0, 0.4),
            plane(5.0, 3.0, 30.0, 0.5),
            plane(15.0, 12.0, 20.0, 0.5),
        ]
    }

    /// The default settings on samplers of these anisotropies.
    fn bases() -> [EwaSettings; 2] {
        [1, 16].map(|sampler_anisotropy| EwaSettings {
            sampler_anisotropy,
            ..EwaSettings::default()
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
        let (surfaces, texture) = (surfaces(), checks(0.02));
        let exact = EwaSettings::with_method(EwaMethod::Reference);
        let expected: Vec<_> = surfaces
            .iter()
            .map(|surface| picture(surface, &texture, &exact).0)
            .collect();
        let mut wrong = Vec::new();
        for candidate in &CANDIDATES {
            let measured = bases().map(|base| {
                let settings = candidate.settings(base);
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

    #[test]
    fn pictures_keep_within_their_budget() {
        let (surfaces, texture) = (surfaces(), checks(0.02));
        for base in bases() {
            for fetches in [
                1.0, 2.0, 4.9, 6.0, 15.0, 24.0, 49.0, 55.0, 80.0, 150.0, 300.0,
            ] {
                let settings = EwaBudget { fetches }.fit_mean(base);
                for surface in &surfaces {
                    let mean = picture(surface, &texture, &settings).1;
                    let allowed = f64::from(fetches) + 0.05;
                    assert!(mean <= allowed, "{mean} of {fetches}: {settings:?}");
                }
            }
        }
    }

    /// Returns the candidate of which these settings are.
    fn chosen(settings: &EwaSettings) -> &'static Candidate {
        let is_chosen = |candidate: &&Candidate| candidate.settings(*settings) == *settings;
        CANDIDATES.iter().find(is_chosen).expect("a candidate")
    }

    #[test]
    fn a_larger_budget_never_has_a_larger_error() {
        for base in bases() {
            let (mut mean, mut worst) = (f32::INFINITY, f32::INFINITY);
            for step in 0..400 {
                let budget = EwaBudget {
                    fetches: 1.03f32.powi(step),
                };
                let next = [budget.fit_mean(base), budget.fit_worst_case(base)]
                    .map(|settings| chosen(&settings).error(base.sampler_anisotropy));
                assert!(next[0] <= mean && next[1] <= worst, "{budget:?}: {next:?}");
                [mean, worst] = next;
            }
            // The largest budgets choose an exact method.
            assert!(mean < 0.1 && worst < 0.1, "{mean} {worst}");
        }
    }

    #[test]
    fn a_smaller_error_never_costs_less_and_is_kept() {
        for base in bases() {
            let mut last = 0.0;
            let bounds = [1e6, 100.0, 98.0, 30.0, 10.0, 5.0, 1.0, 0.15, 0.0, -1.0];
            for bound in bounds.into_iter().chain([f32::NAN]) {
                let mean_squared_error = bound;
                let settings = EwaErrorBound { mean_squared_error }.fit(base);
                let candidate = chosen(&settings);
                assert!(candidate.error(base.sampler_anisotropy) <= bound.max(0.0));
                let fetches = candidate.mean_fetches(base.sampler_anisotropy);
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
                kernel: match KERNELS[kernel] {
                    EwaKernel::Gaussian { .. } => EwaKernel::Gaussian { sigma_pixels: 0.7 },
                    kernel => kernel,
                },
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
            let texture = checks(0.02);
            let major = log_major.exp2();
            let derivatives = rotated(ellipse(major, major / log_ratio.exp2(), angle), rotation);
            let sampled = sample(&texture, [u, v], derivatives, &settings, 0);
            let most = worst_case_fetches(&settings);
            prop_assert!(most <= budget.max(1.0));
            // The texture unit's own filter counts as one fetch; the reference computes it with more.
            if settings.method != EwaMethod::Anisotropic {
                prop_assert!(sampled.fetches as f32 <= most, "{sampled:?} of {most}: {settings:?}");
            }
        }
    }
}

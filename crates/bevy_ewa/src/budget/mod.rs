//! Settings by their cost or by their error.
//!
//! The unit is the texture fetch: of one texel, bilinear, trilinear or, when the sampler's
//! `anisotropy_clamp` is above 1, anisotropic. The number of fetches does not depend on the machine.
//!
//! | module | contents |
//! | --- | --- |
//! | [`cost`] | the candidate settings with measured errors and costs, and an upper bound of the cost of a lookup |

pub mod cost;

#[cfg(test)]
mod tests;

#[cfg(feature = "bevy")]
use bevy::prelude::*;

use crate::settings::EwaSettings;
use cost::{CANDIDATES, Candidate, worst_case_fetches};

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
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
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
        let candidates = CANDIDATES
            .iter()
            .map(|candidate| (candidate, candidate.settings(base)));
        let fitting =
            candidates.filter(|(candidate, settings)| cost(candidate, settings) <= fetches);
        let error = |candidate: &Candidate| candidate.error(base.sampler_anisotropy);
        let best = fitting.min_by(|(a, _), (b, _)| error(a).total_cmp(&error(b)));
        // The texture unit's own filter is one fetch and always fits.
        best.map_or(base, |(_, settings)| settings)
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
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
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

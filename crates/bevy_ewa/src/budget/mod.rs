//! Settings by their cost or by their error.
//!
//! The unit is the texture fetch: of one texel, bilinear, trilinear or, when the sampler's
//! `anisotropy_clamp` is above 1, anisotropic. The number of fetches does not depend on the machine.
//!
//! | module | contents |
//! | --- | --- |
//! | [`error_bound`] | settings by their error |
//! | [`candidates`] | the candidate settings, with measured errors and costs |
//! | [`worst_case`] | an upper bound of the cost of a lookup |

pub mod candidates;
pub mod error_bound;
pub mod worst_case;

#[cfg(test)]
mod tests;

#[cfg(feature = "bevy")]
use bevy::prelude::*;

use crate::settings::EwaSettings;
use candidates::{CANDIDATES, Candidate};
pub use error_bound::EwaErrorBound;

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
        self.choose(base, |_, settings| worst_case::worst_case_fetches(settings))
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

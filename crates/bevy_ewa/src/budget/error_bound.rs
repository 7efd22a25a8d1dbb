//! Settings by their error.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

use super::candidates::CANDIDATES;
use crate::settings::EwaSettings;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EwaMethod;

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
                let is_it = |c: &&super::super::Candidate| c.settings(base) == settings;
                let candidate = CANDIDATES.iter().find(is_it).expect("a candidate");
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
}

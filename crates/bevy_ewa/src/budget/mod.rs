//! Settings by what they may cost.
//!
//! The unit is the texture fetch: of one texel, bilinear, trilinear or, on samplers with
//! anisotropy, the texture unit's own. It is what a lookup costs on every machine.
//!
//! | module | gives |
//! | --- | --- |
//! | [`choices`] | what there is to choose from, with measured errors and costs |
//! | [`worst`] | the most that any lookup can cost |

pub mod choices;
pub mod worst;

#[cfg(test)]
mod tests;

#[cfg(feature = "bevy")]
use bevy::prelude::*;

use crate::settings::EwaSettings;
use choices::{CHOICES, Choice};

/// How many texture fetches a lookup may take; the most accurate method within it follows.
///
/// ```
/// use bevy_ewa::{EwaBudget, EwaMethod, EwaSettings};
///
/// let cheap = EwaBudget { fetches: 3.0 }.mean(EwaSettings::default());
/// assert_eq!(cheap.method, EwaMethod::Hardware);
/// let exact = EwaBudget { fetches: 250.0 }.mean(EwaSettings::default());
/// assert_eq!(exact.method, EwaMethod::Linear);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub struct EwaBudget {
    /// Texture fetches a lookup. From 1, below which there is nothing to choose; what is not a
    /// number counts as 1. Default 32.
    pub fetches: f32,
}

impl Default for EwaBudget {
    fn default() -> Self {
        Self { fetches: 32.0 }
    }
}

impl From<EwaBudget> for EwaSettings {
    /// [`EwaBudget::mean`] for the default settings.
    fn from(budget: EwaBudget) -> Self {
        budget.mean(Self::default())
    }
}

impl EwaBudget {
    /// For the mean of a picture: the most accurate settings that take at most so many fetches a
    /// pixel on each of the study's scenes, floors that fill the picture at 1 to 15 degrees and a
    /// tunnel. A pixel may take more.
    ///
    /// What is not a matter of cost, and `sampler_anisotropy`, is as in `others`; the costs are those
    /// of the default kernel and minor radius.
    pub fn mean(self, others: EwaSettings) -> EwaSettings {
        self.choose(others, |choice, settings| {
            choice.mean_fetches(settings.sampler_anisotropy)
        })
    }

    /// For each pixel: the most accurate settings of which no lookup ever takes more fetches.
    ///
    /// `others` as in [`EwaBudget::mean`], but any kernel and minor radius keep the bound.
    pub fn worst(self, others: EwaSettings) -> EwaSettings {
        self.choose(others, |_, settings| worst::most_fetches(settings))
    }

    fn choose(
        self,
        others: EwaSettings,
        cost: impl Fn(&Choice, &EwaSettings) -> f32,
    ) -> EwaSettings {
        let fetches = self.fetches.max(1.0);
        let candidates = CHOICES
            .iter()
            .map(|choice| (choice, choice.settings(others)));
        let fitting = candidates.filter(|(choice, settings)| cost(choice, settings) <= fetches);
        let error = |choice: &Choice| choice.error(others.sampler_anisotropy);
        let best = fitting.min_by(|(a, _), (b, _)| error(a).total_cmp(&error(b)));
        // The texture unit's own filter is one fetch and always fits.
        best.map_or(others, |(_, settings)| settings)
    }
}

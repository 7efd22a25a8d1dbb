//! From coefficients to the `[0, 1]` that a BC3 texel holds, and back (thesis section 3.5.2).

use serde::{Deserialize, Serialize};

use super::haar::{Details, Transform};

/// How the coefficients of one plane are stored; all a decoder must know of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneCoding {
    /// Mean of 2 x 2 pixels (LL / 2) that alpha 0 stands for, in units of the plane.
    pub mean_min: f32,
    /// Mean that alpha 1 stands for; larger than `mean_min`.
    pub mean_max: f32,
    /// Largest stored detail, in units of the plane; what is beyond is clamped. Positive.
    pub range: f32,
    /// Exponent of the signed power curve around zero, in `(0, 1]`; 1 is linear. Smaller values
    /// spend more of the code on small details.
    pub gamma: f32,
    /// How the details are mixed before they are stored.
    pub transform: Transform,
}

/// Details beyond this are no image's.
const LARGEST_MAGNITUDE: f32 = 65536.0;

impl PlaneCoding {
    /// Whether a decoder can work with it: finite, in range and invertible.
    pub fn is_valid(&self) -> bool {
        let bounded = |v: f32| v.abs() <= LARGEST_MAGNITUDE;
        bounded(self.mean_min)
            && bounded(self.mean_max)
            && self.mean_max > self.mean_min
            && self.range > 0.0
            && bounded(self.range)
            && self.gamma >= 0.1
            && self.gamma <= 1.0
            && self.transform.is_valid()
            // A tiny w amplifies: what it makes of the largest detail must stay an image's too.
            && self.transform.unmix_rows().iter().flatten().all(|m| bounded(m * self.range))
    }

    /// Mean to alpha.
    pub fn store_mean(&self, mean: f32) -> f32 {
        ((mean - self.mean_min) / (self.mean_max - self.mean_min)).clamp(0.0, 1.0)
    }

    /// Alpha to mean.
    pub fn load_mean(&self, stored: f32) -> f32 {
        self.mean_min + stored * (self.mean_max - self.mean_min)
    }

    /// HL, LH, HH to RGB.
    pub fn store_details(&self, details: Details) -> Details {
        self.transform.mix(details).map(|detail| {
            let normalized = (detail / self.range).clamp(-1.0, 1.0);
            0.5 + 0.5 * normalized.abs().powf(self.gamma).copysign(normalized)
        })
    }

    /// RGB to HL, LH, HH.
    pub fn load_details(&self, stored: Details) -> Details {
        self.transform.unmix(stored.map(|stored| {
            let curved = 2.0 * stored - 1.0;
            self.range * curved.abs().powf(1.0 / self.gamma).copysign(curved)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn coding(gamma: f32, transform: Transform) -> PlaneCoding {
        PlaneCoding {
            mean_min: -0.25,
            mean_max: 1.25,
            range: 3.0,
            gamma,
            transform,
        }
    }

    proptest! {
        #[test]
        fn what_is_in_range_survives(
            mean in -0.25f32..1.25,
            details in prop::array::uniform3(-1.0f32..1.0),
            gamma in 0.3f32..=1.0,
            w in 0.05f32..=1.0,
        ) {
            for transform in [Transform::Haar, Transform::PartiallyInvertedHaar { w }] {
                let c = coding(gamma, transform);
                prop_assert!((c.load_mean(c.store_mean(mean)) - mean).abs() < 1e-5);
                let back = c.load_details(c.store_details(details));
                for (a, b) in back.iter().zip(details) {
                    prop_assert!((a - b).abs() < 1e-5 + 1e-6 / w);
                }
            }
        }

        #[test]
        fn any_finite_detail_is_stored_within_the_unit_interval(
            details in prop::array::uniform3(prop::num::f32::NORMAL),
        ) {
            let stored = coding(0.5, Transform::Haar).store_details(details);
            prop_assert!(stored.iter().all(|v| (0.0..=1.0).contains(v)));
        }
    }

    #[test]
    fn nonsense_is_not_valid() {
        let good = coding(0.86, Transform::Haar);
        assert!(good.is_valid());
        for bad in [
            PlaneCoding {
                mean_max: good.mean_min,
                ..good
            },
            PlaneCoding {
                mean_min: f32::NAN,
                ..good
            },
            PlaneCoding { range: 0.0, ..good },
            PlaneCoding {
                range: f32::INFINITY,
                ..good
            },
            PlaneCoding { gamma: 0.0, ..good },
            PlaneCoding {
                gamma: f32::NAN,
                ..good
            },
            PlaneCoding {
                transform: Transform::PartiallyInvertedHaar { w: 0.0 },
                ..good
            },
        ] {
            assert!(!bad.is_valid(), "{bad:?}");
        }
    }
}

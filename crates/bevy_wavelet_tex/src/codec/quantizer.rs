//! From coefficients to the `[0, 1]` that a BC3 texel holds, and back (thesis section 3.5.2).

use serde::{Deserialize, Serialize};

use super::{
    haar::{Details, Transform},
    image::Packing,
};

/// How the values of one plane are stored; all a decoder must know of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneCoding {
    /// Value (of wavelet packings: mean of 2 x 2 pixels, LL / 2) that 0 stands for, in units of the
    /// plane.
    pub mean_min: f32,
    /// Value that 1 stands for; larger than `mean_min`.
    pub mean_max: f32,
    /// Largest stored detail, in units of the plane; what is beyond is clamped. Positive.
    pub range: f32,
    /// Exponent of the signed power curve around zero, in `[0.1, 1]`; 1 is linear. Smaller values
    /// spend more of the code on small details.
    pub gamma: f32,
    /// What the details' zero is stored as, in `[0.25, 0.75]`: a code that the format has, so that
    /// flat areas are exact.
    pub centre: Details,
    /// How much of a detail the neighbours' means foretell, in `[-1, 1]`; 0 is not at all. See
    /// [`predict`](super::predict).
    pub predictor: f32,
    /// How the details are mixed before they are stored.
    pub transform: Transform,
}

/// Details beyond this are no image's.
const LARGEST_MAGNITUDE: f32 = 65536.0;

impl PlaneCoding {
    /// Zero among the 5:6:5 codes of BC3: 16 of 31, 32 of 63.
    pub const CENTRE_565: Details = [16.0 / 31.0, 32.0 / 63.0, 16.0 / 31.0];
    /// Zero among 8-bit codes.
    pub const CENTRE_8: Details = [128.0 / 255.0; 3];

    /// Details as they are, in `[-1, 1]`, and means in this interval.
    pub fn linear([mean_min, mean_max]: [f32; 2]) -> Self {
        Self {
            mean_min,
            mean_max,
            range: 1.0,
            gamma: 1.0,
            centre: [0.5; 3],
            predictor: 0.0,
            transform: Transform::Haar,
        }
    }

    /// Whether a decoder can work with it: finite, in range and invertible where `packing` needs it.
    pub fn is_valid(&self, packing: Packing) -> bool {
        let bounded = |v: f32| v.abs() <= LARGEST_MAGNITUDE;
        bounded(self.mean_min)
            && bounded(self.mean_max)
            && self.mean_max > self.mean_min
            && self.range > 0.0
            && bounded(self.range)
            && (0.1..=1.0).contains(&self.gamma)
            && self.centre.iter().all(|c| (0.25..=0.75).contains(c))
            && (-1.0..=1.0).contains(&self.predictor)
            && self.transform.is_valid(packing)
            // A tiny w amplifies: what it makes of the largest detail must stay an image's too.
            && self.transform.unmix_rows().iter().flatten().all(|m| bounded(m * self.range))
    }

    /// Mean to what is stored.
    pub fn store_mean(&self, mean: f32) -> f32 {
        ((mean - self.mean_min) / (self.mean_max - self.mean_min)).clamp(0.0, 1.0)
    }

    /// What is stored to mean.
    pub fn load_mean(&self, stored: f32) -> f32 {
        self.mean_min + stored * (self.mean_max - self.mean_min)
    }

    /// A mixed detail to what channel `c` stores.
    pub fn store_detail(&self, c: usize, mixed: f32) -> f32 {
        let normalized = (mixed / self.range).clamp(-1.0, 1.0);
        let curved = normalized.abs().powf(self.gamma).copysign(normalized);
        (self.centre[c] + 0.5 * curved).clamp(0.0, 1.0)
    }

    /// What channel `c` stores to a mixed detail.
    pub fn load_detail(&self, c: usize, stored: f32) -> f32 {
        let curved = 2.0 * (stored - self.centre[c]);
        self.range * curved.abs().powf(1.0 / self.gamma).copysign(curved)
    }

    /// HL, LH, HH (what the predictor left of them) to RGB.
    pub fn store_details(&self, details: Details) -> Details {
        let mixed = self.transform.mix(details);
        std::array::from_fn(|c| self.store_detail(c, mixed[c]))
    }

    /// RGB to HL, LH, HH, to which the prediction is to be added.
    pub fn load_details(&self, stored: Details) -> Details {
        let mixed = std::array::from_fn(|c| self.load_detail(c, stored[c]));
        self.transform.unmix(mixed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn coding(gamma: f32, transform: Transform) -> PlaneCoding {
        PlaneCoding {
            range: 3.0,
            gamma,
            transform,
            ..PlaneCoding::linear([-0.25, 1.25])
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
        fn zero_is_stored_exactly_where_the_format_has_a_code(gamma in 0.3f32..=1.0) {
            for (centre, steps) in [
                (PlaneCoding::CENTRE_565, [31.0, 63.0, 31.0]),
                (PlaneCoding::CENTRE_8, [255.0; 3]),
            ] {
                let coding = PlaneCoding { centre, ..coding(gamma, Transform::Haar) };
                let stored = coding.store_details([0.0; 3]);
                for c in 0..3 {
                    let code: f32 = stored[c] * steps[c];
                    prop_assert!((code - code.round()).abs() < 1e-4);
                }
                prop_assert_eq!(coding.load_details(stored), [0.0; 3]);
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
        assert!(good.is_valid(Packing::Bc3));
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
                centre: [0.5, 1.0, 0.5],
                ..good
            },
            PlaneCoding {
                predictor: f32::NAN,
                ..good
            },
            PlaneCoding {
                transform: Transform::PartiallyInvertedHaar { w: 0.0 },
                ..good
            },
        ] {
            assert!(!bad.is_valid(Packing::Bc3), "{bad:?}");
        }
    }
}

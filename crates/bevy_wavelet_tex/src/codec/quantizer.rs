//! Quantisation of coefficients to the `[0, 1]` that a texel of a block format holds, and back
//! (thesis section 3.5.2).

use serde::{Deserialize, Serialize};

use super::{
    haar::{Details, Transform},
    packing::Packing,
};

/// How the values of one plane are stored: all parameters that its decoder needs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneCoding {
    /// The value that 0 stands for, in units of the plane: of the low band (LL / 2, the mean of 2 x
    /// 2 pixels) in wavelet packings, of the pixels in the others.
    pub low_min: f32,
    /// The value that 1 stands for; larger than `low_min`.
    pub low_max: f32,
    /// Largest stored detail, in units of the plane, positive; larger ones are clamped. A smaller
    /// range stores small details with a smaller error, but clamps more of the strong edges.
    pub range: f32,
    /// Exponent of the signed power curve around zero, in `[0.1, 1]`; 1 is linear. Smaller values
    /// give more of the codes to small details.
    pub gamma: f32,
    /// The zero point: the stored value of a detail of zero, in `[0.25, 0.75]`. It is a code that
    /// the block format has, so that flat areas are exact.
    pub zero_point: Details,
    /// Weight of the prediction from the neighbouring values of the low band, in `[-1, 1]`; 0
    /// disables it. See [`predict`](super::predict).
    pub predictor: f32,
    /// Linear transform of the details before they are stored.
    pub transform: Transform,
}

/// Largest magnitude of a coefficient that an image can have; larger values in a file are damage.
const LARGEST_MAGNITUDE: f32 = 65536.0;

impl PlaneCoding {
    /// The zero point among the 5:6:5 codes of BC3: 16 of 31, 32 of 63.
    pub const ZERO_POINT_565: Details = [16.0 / 31.0, 32.0 / 63.0, 16.0 / 31.0];
    /// The zero point among 8-bit codes.
    pub const ZERO_POINT_8: Details = [128.0 / 255.0; 3];

    /// Stores details in `[-1, 1]` without a curve or a prediction, and the low band (or the
    /// pixels) in the given interval.
    pub fn linear([low_min, low_max]: [f32; 2]) -> Self {
        Self {
            low_min,
            low_max,
            range: 1.0,
            gamma: 1.0,
            zero_point: [0.5; 3],
            predictor: 0.0,
            transform: Transform::Haar,
        }
    }

    /// Returns whether a decoder can use the parameters: they are finite, in range, and the
    /// transform can be inverted where `packing` needs it.
    pub fn is_valid(&self, packing: Packing) -> bool {
        let bounded = |v: f32| v.abs() <= LARGEST_MAGNITUDE;
        bounded(self.low_min)
            && bounded(self.low_max)
            && self.low_max > self.low_min
            && self.range > 0.0
            && bounded(self.range)
            && (0.1..=1.0).contains(&self.gamma)
            && self.zero_point.iter().all(|c| (0.25..=0.75).contains(c))
            && (-1.0..=1.0).contains(&self.predictor)
            && self.transform.is_valid(packing)
            // A small w amplifies the details, and the largest one must stay in range after that.
            && self.transform.unmix_rows().iter().flatten().all(|m| bounded(m * self.range))
    }

    /// Converts a value of the low band to its stored value.
    pub fn store_low(&self, low: f32) -> f32 {
        ((low - self.low_min) / (self.low_max - self.low_min)).clamp(0.0, 1.0)
    }

    /// Converts a stored value to a value of the low band.
    pub fn load_low(&self, stored: f32) -> f32 {
        self.low_min + stored * (self.low_max - self.low_min)
    }

    /// Converts a transformed detail to the stored value of channel `c`.
    pub fn store_detail(&self, c: usize, mixed: f32) -> f32 {
        let normalized = (mixed / self.range).clamp(-1.0, 1.0);
        let curved = normalized.abs().powf(self.gamma).copysign(normalized);
        (self.zero_point[c] + 0.5 * curved).clamp(0.0, 1.0)
    }

    /// Converts the stored value of channel `c` to a transformed detail.
    pub fn load_detail(&self, c: usize, stored: f32) -> f32 {
        let curved = 2.0 * (stored - self.zero_point[c]);
        self.range * curved.abs().powf(1.0 / self.gamma).copysign(curved)
    }

    /// Converts the residuals of HL, LH and HH to RGB.
    pub fn store_details(&self, details: Details) -> Details {
        let mixed = self.transform.mix(details);
        std::array::from_fn(|c| self.store_detail(c, mixed[c]))
    }

    /// Converts RGB to HL, LH and HH, to which the prediction must be added.
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
            low in -0.25f32..1.25,
            details in prop::array::uniform3(-1.0f32..1.0),
            gamma in 0.3f32..=1.0,
            w in 0.05f32..=1.0,
        ) {
            for transform in [Transform::Haar, Transform::PartiallyInvertedHaar { w }] {
                let c = coding(gamma, transform);
                prop_assert!((c.load_low(c.store_low(low)) - low).abs() < 1e-5);
                let back = c.load_details(c.store_details(details));
                for (a, b) in back.iter().zip(details) {
                    prop_assert!((a - b).abs() < 1e-5 + 1e-6 / w);
                }
            }
        }

        #[test]
        fn zero_is_stored_exactly_where_the_format_has_a_code(gamma in 0.3f32..=1.0) {
            for (zero_point, steps) in [
                (PlaneCoding::ZERO_POINT_565, [31.0, 63.0, 31.0]),
                (PlaneCoding::ZERO_POINT_8, [255.0; 3]),
            ] {
                let coding = PlaneCoding { zero_point, ..coding(gamma, Transform::Haar) };
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
        let faults: [fn(&mut PlaneCoding); 9] = [
            |coding| coding.low_max = coding.low_min,
            |coding| coding.low_min = f32::NAN,
            |coding| coding.range = 0.0,
            |coding| coding.range = f32::INFINITY,
            |coding| coding.gamma = 0.0,
            |coding| coding.gamma = f32::NAN,
            |coding| coding.zero_point = [0.5, 1.0, 0.5],
            |coding| coding.predictor = f32::NAN,
            |coding| coding.transform = Transform::PartiallyInvertedHaar { w: 0.0 },
        ];
        for spoil in faults {
            let mut bad = good;
            spoil(&mut bad);
            assert!(!bad.is_valid(Packing::Bc3), "{bad:?}");
        }
    }
}

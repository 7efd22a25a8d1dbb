//! The Haar transform of 2 x 2 pixels and its partially inverted form (thesis section 3.5.1).

use serde::{Deserialize, Serialize};

use super::packing::Packing;

/// The three detail coefficients of 2 x 2 pixels, in the order in which they are stored as R, G, B.
pub type Details = [f32; 3];

/// The four coefficients of 2 x 2 pixels.
///
/// With Eq. 3.15's factor 1/2 the transform is orthonormal and its own inverse: the squared error
/// of the coefficients is the squared error of the pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Scale coefficient (LL), twice the mean of the pixels.
    pub ll: f32,
    /// Horizontal, vertical and diagonal detail: HL, LH, HH.
    pub details: Details,
}

/// Transforms pixels `[a, b, c, d]` (a b above c d) to coefficients (Eq. 3.15).
pub fn haar([a, b, c, d]: [f32; 4]) -> Coefficients {
    Coefficients {
        ll: (a + b + c + d) / 2.0,
        details: [
            (a - b + c - d) / 2.0,
            (a + b - c - d) / 2.0,
            (a - b - c + d) / 2.0,
        ],
    }
}

/// Transforms coefficients to pixels `[a, b, c, d]` by Eq. 3.15 again.
pub fn inverse_haar(
    Coefficients {
        ll,
        details: [hl, lh, hh],
    }: Coefficients,
) -> [f32; 4] {
    let pixels = haar([ll, hl, lh, hh]);
    [
        pixels.ll,
        pixels.details[0],
        pixels.details[1],
        pixels.details[2],
    ]
}

/// Linear transform of the details before they are stored.
///
/// BC3 encodes the three channels of a block along one line through RGB space, so the error falls
/// when the channels are more correlated than the Haar details are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Transform {
    /// HL, LH and HH without a transform.
    Haar,
    /// Partially inverted Haar (Eq. 3.16).
    PartiallyInvertedHaar {
        /// Weight of HH, in `[0, 1]`. The error of HH grows as 1 / (2 w). 0 drops HH, which is
        /// valid only for a packing that does not store it.
        w: f32,
    },
}

impl Transform {
    /// Returns whether the transform can be inverted: `w` in `(0, 1]`, or 0 where the packing drops
    /// HH.
    pub fn is_valid(self, packing: Packing) -> bool {
        match self {
            Self::Haar => true,
            Self::PartiallyInvertedHaar { w: 0.0 } => packing == Packing::Bc7,
            Self::PartiallyInvertedHaar { w } => w > 0.0 && w <= 1.0 && (0.5 / w).is_finite(),
        }
    }

    /// Transforms HL, LH, HH to the stored details.
    pub fn mix(self, [hl, lh, hh]: Details) -> Details {
        match self {
            Self::Haar => [hl, lh, hh],
            Self::PartiallyInvertedHaar { w } => {
                [hl + lh + w * hh, -hl + lh - w * hh, hl - lh - w * hh]
            }
        }
    }

    /// Rows of the matrix that transforms the stored details to HL, LH, HH, which the shader gets
    /// in its uniform.
    pub fn unmix_rows(self) -> [[f32; 3]; 3] {
        match self {
            Self::Haar => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            // Two rows of Eq. 3.16 suffice to separate HL and LH; the third is not stored.
            Self::PartiallyInvertedHaar { w: 0.0 } => {
                [[0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 0.0]]
            }
            Self::PartiallyInvertedHaar { w } => {
                let h = -0.5 / w;
                [[0.5, 0.0, 0.5], [0.5, 0.5, 0.0], [0.0, h, h]]
            }
        }
    }

    /// Transforms the stored details to HL, LH, HH.
    pub fn unmix(self, stored: Details) -> Details {
        self.unmix_rows()
            .map(|row| row[0] * stored[0] + row[1] * stored[1] + row[2] * stored[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn assert_near(a: &[f32], b: &[f32], tolerance: f32) {
        for (a, b) in a.iter().zip(b) {
            assert!(
                (a - b).abs() <= tolerance,
                "{a} is not {b} within {tolerance}"
            );
        }
    }

    #[test]
    fn bands_respond_to_their_own_pattern_only() {
        assert_eq!(
            haar([1.0; 4]),
            Coefficients {
                ll: 2.0,
                details: [0.0; 3]
            }
        );
        assert_eq!(haar([1.0, 0.0, 1.0, 0.0]).details, [1.0, 0.0, 0.0]); // a vertical edge
        assert_eq!(haar([1.0, 1.0, 0.0, 0.0]).details, [0.0, 1.0, 0.0]);
        assert_eq!(haar([1.0, 0.0, 0.0, 1.0]).details, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn w_outside_its_interval_is_not_valid() {
        for w in [0.0, -0.5, 1.01, f32::NAN, f32::INFINITY, f32::from_bits(1)] {
            let transform = Transform::PartiallyInvertedHaar { w };
            assert!(!transform.is_valid(Packing::Bc3), "w = {w}");
            assert_eq!(transform.is_valid(Packing::Bc7), w == 0.0, "w = {w}");
        }
    }

    #[test]
    fn without_hh_the_other_two_come_back() {
        let t = Transform::PartiallyInvertedHaar { w: 0.0 };
        let [a, b, _] = t.mix([0.25, -0.125, 0.5]);
        assert_eq!(t.unmix([a, b, 9.0]), [0.25, -0.125, 0.0]);
    }

    proptest! {
        #[test]
        fn haar_is_orthonormal_and_its_own_inverse(pixels in prop::array::uniform4(-1.0f32..1.0)) {
            let c = haar(pixels);
            assert_near(&inverse_haar(c), &pixels, 1e-6);
            let energy = |v: &[f32]| v.iter().map(|x| x * x).sum::<f32>();
            prop_assert!((energy(&pixels) - c.ll * c.ll - energy(&c.details)).abs() < 1e-5);
        }

        #[test]
        fn mixing_inverts_for_every_w(
            details in prop::array::uniform3(-1.0f32..1.0),
            log_w in -10.0f32..0.0,
        ) {
            let w = log_w.exp2();
            let t = Transform::PartiallyInvertedHaar { w };
            // The rounding errors of the sums are amplified by 1 / (2 w) in HH.
            assert_near(&t.unmix(t.mix(details)), &details, 1e-6 + 4e-7 / w);
        }
    }
}

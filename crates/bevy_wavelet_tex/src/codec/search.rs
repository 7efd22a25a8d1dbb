//! The choice of a plane's parameters by measured error (thesis section 3.5.2).
//!
//! The transform is orthonormal, so the squared error of the details is that of the pixels, and the
//! means, which BC3 codes on their own, do not matter here. A coordinate descent over transform,
//! range and power curve costs some 20 encodings of a sample of the blocks.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    blocks::{BlockQuality, decode_bc3, encode_bc3},
    decoder::load_texel,
    encoder::{CoefficientPlane, store_texel},
    haar::{Coefficients, Details, Transform},
    quantizer::PlaneCoding,
};

/// How hard the encoder searches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Effort {
    /// No search: the values to which the search converges for most images. For previews.
    Fast,
    /// A search over a sample of 2048 blocks.
    #[default]
    Default,
    /// A finer search over a sample of 16384 blocks.
    Best,
}

const TRANSFORMS: [Transform; 6] = [
    Transform::Haar,
    Transform::PartiallyInvertedHaar { w: 0.2 },
    Transform::PartiallyInvertedHaar { w: 0.4 },
    Transform::PartiallyInvertedHaar { w: 0.6 },
    Transform::PartiallyInvertedHaar { w: 0.8 },
    Transform::PartiallyInvertedHaar { w: 1.0 },
];
/// Fractions of the largest mixed detail.
const RANGES: [f32; 6] = [1.0, 0.74, 0.55, 0.4, 0.3, 0.2];
const GAMMAS: [f32; 5] = [1.0, 0.86, 0.75, 0.65, 0.55];

/// Chooses how to store a plane.
pub(super) fn choose_coding(plane: &CoefficientPlane, effort: Effort) -> PlaneCoding {
    let means = plane.coefficients.iter().map(|c| c.ll / 2.0);
    let [mean_min, mean_max] = bounds(means);
    let candidate = |transform: Transform, range_fraction: f32, gamma: f32| {
        let range = range_fraction * largest_detail(&plane.coefficients, transform);
        PlaneCoding {
            mean_min,
            mean_max,
            range,
            gamma,
            transform,
        }
    };
    let start = (TRANSFORMS[0], 0.55, 0.86);
    let (sample_blocks, rounds) = match effort {
        Effort::Fast => return candidate(start.0, start.1, start.2),
        Effort::Default => (2048, 1),
        Effort::Best => (16384, 2),
    };
    let sample = plane.sample_blocks(sample_blocks);
    let best_of = |codings: Vec<Choice>| -> Choice {
        let errors: Vec<f64> = codings
            .par_iter()
            .map(|&(t, r, g)| squared_error(&sample, &candidate(t, r, g)))
            .collect();
        let best = (0..codings.len()).min_by(|&a, &b| errors[a].total_cmp(&errors[b]));
        codings[best.expect("there are candidates")]
    };
    let mut best = start;
    for round in 0..rounds {
        best = best_of(TRANSFORMS.map(|t| (t, best.1, best.2)).to_vec());
        best = if round == 0 {
            best_of(RANGES.map(|r| (best.0, r, best.2)).to_vec())
        } else {
            best_of(
                [0.8, 0.9, 1.0, 1.1, 1.2]
                    .map(|s| (best.0, best.1 * s, best.2))
                    .to_vec(),
            )
        };
        best = best_of(GAMMAS.map(|g| (best.0, best.1, g)).to_vec());
        best = best_of(
            [0.88, 1.0, 1.14]
                .map(|s| (best.0, best.1 * s, best.2))
                .to_vec(),
        );
    }
    candidate(best.0, best.1, best.2)
}

/// Transform, range as a fraction of the largest mixed detail, gamma.
type Choice = (Transform, f32, f32);

/// Squared error of the details when the sampled blocks are stored so.
fn squared_error(sample: &[Coefficients], coding: &PlaneCoding) -> f64 {
    let size = [sample.len() as u32 / 4, 4];
    let opaque = |c: &Coefficients| {
        let [r, g, b, _] = store_texel(coding, c);
        [r, g, b, 255]
    };
    let texels: Vec<_> = sample.iter().map(opaque).collect();
    let decoded = decode_bc3(&encode_bc3(&texels, size, BlockQuality::Normal), size);
    let error = |(c, texel): (&Coefficients, _)| {
        let back: Details = load_texel(coding, texel).details;
        c.details
            .iter()
            .zip(back)
            .map(|(a, b)| f64::from(a - b).powi(2))
            .sum::<f64>()
    };
    sample.iter().zip(decoded).map(error).sum()
}

fn largest_detail(coefficients: &[Coefficients], transform: Transform) -> f32 {
    let largest = |c: &Coefficients| transform.mix(c.details).map(f32::abs).into_iter();
    // A flat image has no details; any positive range stores them exactly.
    coefficients
        .iter()
        .flat_map(largest)
        .fold(1.0 / 255.0, f32::max)
}

/// The interval of the values, widened to one 8-bit step where it is shorter.
fn bounds(values: impl Iterator<Item = f32>) -> [f32; 2] {
    let [min, max] = values.fold([f32::INFINITY, f32::NEG_INFINITY], |[min, max], v| {
        [min.min(v), max.max(v)]
    });
    [min, max.max(min + 1.0 / 255.0)]
}

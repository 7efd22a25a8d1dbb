//! Search for the parameters of a plane by the measured error (thesis section 3.5.2).
//!
//! The transform is orthonormal, so the squared error of the details is that of the pixels, and the
//! low band, which is coded independently, does not matter here. The predictor has a closed form;
//! range and power curve are found by coordinate descent over a sample of the blocks.

use rayon::prelude::*;

use super::{
    blocks::{
        BlockFormat, BlockQuality, DetailEncoder, Starts, decode_blocks, encode_bc3, encode_bc7,
    },
    haar::{Details, Transform},
    packing::Packing,
    plane::Plane,
    predict::{best_predictor, predicted, slopes},
    quantizer::PlaneCoding,
    settings::Effort,
    wavelet::CoefficientPlane,
};

/// Candidates for the transform of the thesis.
const MIXES: [Transform; 6] = [
    Transform::Haar,
    Transform::PartiallyInvertedHaar { w: 0.2 },
    Transform::PartiallyInvertedHaar { w: 0.4 },
    Transform::PartiallyInvertedHaar { w: 0.6 },
    Transform::PartiallyInvertedHaar { w: 0.8 },
    Transform::PartiallyInvertedHaar { w: 1.0 },
];

/// Largest stored detail of a plane whose values span 1, to which most images converge.
const USUAL_RANGE: f32 = 0.5;

/// Chooses how to store a plane in the wavelet packing `packing`. `low_bounds` is the interval of the
/// low band.
pub(super) fn choose_coding(
    coefficients: &CoefficientPlane,
    low_bounds: [f32; 2],
    packing: Packing,
    effort: Effort,
    predict: bool,
) -> PlaneCoding {
    let mut coding = PlaneCoding::linear(low_bounds);
    let (gamma, zero_point) = match packing {
        Packing::Bc3 => (0.6, PlaneCoding::ZERO_POINT_565),
        _ => (0.86, PlaneCoding::ZERO_POINT_8),
    };
    coding.gamma = gamma;
    coding.zero_point = zero_point;
    coding.predictor = if predict {
        predictor(coefficients)
    } else {
        0.0
    };
    let largest = largest(coefficients.details.iter().copied());
    coding.range = (USUAL_RANGE * (low_bounds[1] - low_bounds[0])).min(largest);
    // This range clamps nothing. It is larger than the largest detail because the zero point is
    // above the middle of the codes, which leaves a little less room for positive details.
    let all = 1.07 * largest;
    let (count, rounds) = match effort {
        Effort::Fast => return coding,
        Effort::Default => (512, 1),
        Effort::Best => (4096, 2),
    };
    let sample = sample(coefficients, coding.predictor, count);
    let error = |candidate: &PlaneCoding| match packing {
        Packing::Bc3 => details_error(&sample, candidate),
        _ => bc7_error(&sample, candidate, packing),
    };
    // The error of `coding` is known, so that it is measured once.
    let mut known = error(&coding);
    let mut best_of = |coding: PlaneCoding, others: Vec<PlaneCoding>| {
        let mut errors: Vec<f64> = others.par_iter().map(error).collect();
        errors.push(known);
        let best = least(&errors);
        known = errors[best];
        others.get(best).copied().unwrap_or(coding)
    };
    for round in 0..rounds {
        let gammas: &[f32] = if round > 0 {
            &[0.92, 1.08]
        } else {
            &[0.8, 1.2]
        };
        let with_gamma = |g: &f32| PlaneCoding {
            gamma: (coding.gamma * g).clamp(0.3, 1.0),
            ..coding
        };
        coding = best_of(coding, gammas.iter().map(with_gamma).collect());
        let ranges: &[f32] = if round > 0 {
            &[0.85, 0.92, 1.08, 1.17]
        } else {
            &[0.6, 1.4]
        };
        let with_range = |range: f32| PlaneCoding {
            range: range.min(all),
            ..coding
        };
        let scaled = ranges.iter().map(|r| coding.range * r);
        let whole = (round == 0).then_some(all);
        coding = best_of(coding, scaled.chain(whole).map(with_range).collect());
    }
    coding
}

/// The same as the thesis does it: searches the transform, the clamping and the power curve,
/// without prediction.
pub(super) fn choose_thesis_coding(
    coefficients: &CoefficientPlane,
    low_bounds: [f32; 2],
    packing: Packing,
    effort: Effort,
) -> PlaneCoding {
    let coding = PlaneCoding::linear(low_bounds);
    if packing == Packing::Bc7 {
        let transform = Transform::PartiallyInvertedHaar { w: 0.0 };
        let mixed = coefficients.details.iter().map(|d| transform.mix(*d));
        return PlaneCoding {
            transform,
            range: 0.74 * largest(mixed.map(|[a, b, _]| [a, b, 0.0])),
            gamma: 0.86,
            ..coding
        };
    }
    let candidate = |(transform, fraction, gamma): (Transform, f32, f32)| {
        let mixed = coefficients.details.iter().map(|d| transform.mix(*d));
        PlaneCoding {
            transform,
            range: fraction * largest(mixed),
            gamma,
            ..coding
        }
    };
    let mut best = (Transform::Haar, 0.55, 0.86);
    let (count, rounds) = match effort {
        Effort::Fast => return candidate(best),
        Effort::Default => (2048, 1),
        Effort::Best => (16384, 2),
    };
    let sample = sample(coefficients, 0.0, count);
    let best_of = |choices: Vec<(Transform, f32, f32)>| {
        let errors: Vec<f64> = choices
            .par_iter()
            .map(|&choice| mixed_error(&sample, &candidate(choice)))
            .collect();
        choices[least(&errors)]
    };
    for round in 0..rounds {
        best = best_of(MIXES.map(|t| (t, best.1, best.2)).to_vec());
        let fractions = if round == 0 {
            vec![1.0, 0.74, 0.55, 0.4, 0.3, 0.2]
        } else {
            [0.8, 0.9, 1.0, 1.1, 1.2].map(|s| best.1 * s).to_vec()
        };
        best = best_of(fractions.into_iter().map(|f| (best.0, f, best.2)).collect());
        best = best_of(
            [1.0, 0.86, 0.75, 0.65, 0.55]
                .map(|g| (best.0, best.1, g))
                .to_vec(),
        );
        best = best_of(
            [0.88, 1.0, 1.14]
                .map(|s| (best.0, best.1 * s, best.2))
                .to_vec(),
        );
    }
    candidate(best)
}

fn least(errors: &[f64]) -> usize {
    (0..errors.len())
        .min_by(|&a, &b| errors[a].total_cmp(&errors[b]))
        .expect("there are candidates")
}

fn predictor(coefficients: &CoefficientPlane) -> f32 {
    let [width, height] = coefficients.low_band.size;
    let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    best_predictor(positions.map(|(x, y)| {
        (
            slopes(&coefficients.low_band, x, y),
            coefficients.details(x, y),
        )
    }))
}

/// The details of one 4 x 4 block.
type Block = [Details; 16];

/// At most `count` 4 x 4 blocks of the residual, evenly spaced among the blocks in the order of
/// their energy, because a few strong edges decide where clamping pays.
fn sample(coefficients: &CoefficientPlane, predictor: f32, count: usize) -> Vec<Block> {
    let [columns, rows] = coefficients.low_band.size.map(|s| s.div_ceil(4));
    let total = columns as usize * rows as usize;
    let block = |block: usize| -> Block {
        let block = block as u32;
        std::array::from_fn(|i| {
            let [width, height] = coefficients.low_band.size;
            let x = (block % columns * 4 + i as u32 % 4).min(width - 1);
            let y = (block / columns * 4 + i as u32 / 4).min(height - 1);
            let prediction = predicted(&coefficients.low_band, x, y, predictor);
            let details = coefficients.details(x, y);
            std::array::from_fn(|c| details[c] - prediction[c])
        })
    };
    if total <= count {
        return (0..total).map(block).collect();
    }
    let energy = |b: usize| block(b).iter().flatten().map(|d| d * d).sum::<f32>();
    let mut by_energy: Vec<(f32, usize)> =
        (0..total).into_par_iter().map(|b| (energy(b), b)).collect();
    by_energy.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let middle = |i: usize| by_energy[(2 * i + 1) * total / (2 * count)].1;
    (0..count).map(|i| block(middle(i))).collect()
}

fn details_error(sample: &[Block], coding: &PlaneCoding) -> f64 {
    let encoder = DetailEncoder::new(coding, Starts::One);
    sample
        .iter()
        .map(|block| f64::from(encoder.block(block).1))
        .sum()
}

fn bc7_error(sample: &[Block], coding: &PlaneCoding, packing: Packing) -> f64 {
    let size = [4 * sample.len() as u32, 4];
    let dropped = packing == Packing::Bc7;
    let at = |x: u32, y: u32| sample[(x / 4) as usize][(y * 4 + x % 4) as usize];
    let blocks = encode_bc7(size, [1; 3], |x, y| {
        let [r, g, b] = coding.store_details(at(x, y));
        [r, g, if dropped { coding.zero_point[2] } else { b }]
    });
    let texels = decode_blocks(BlockFormat::Bc7, &blocks, size);
    sum_of_errors(size, &texels, coding, at)
}

fn mixed_error(sample: &[Block], coding: &PlaneCoding) -> f64 {
    let size = [4 * sample.len() as u32, 4];
    let at = |x: u32, y: u32| sample[(x / 4) as usize][(y * 4 + x % 4) as usize];
    let texels = Plane::positions(size).map(|(x, y)| {
        let [r, g, b] = coding
            .store_details(at(x, y))
            .map(|v| (v * 255.0).round() as u8);
        [r, g, b, 255]
    });
    let blocks = encode_bc3(&texels.collect::<Vec<_>>(), size, BlockQuality::Normal);
    let texels = decode_blocks(BlockFormat::Bc3, &blocks, size);
    sum_of_errors(size, &texels, coding, at)
}

fn sum_of_errors(
    size: [u32; 2],
    texels: &[[f32; 4]],
    coding: &PlaneCoding,
    wanted: impl Fn(u32, u32) -> Details,
) -> f64 {
    let errors = Plane::positions(size).zip(texels).map(|((x, y), t)| {
        let (got, wanted) = (coding.load_details([t[0], t[1], t[2]]), wanted(x, y));
        (0..3)
            .map(|c| f64::from(got[c] - wanted[c]).powi(2))
            .sum::<f64>()
    });
    errors.sum()
}

/// Largest magnitude over all channels. It has a lower limit because a flat image has no details,
/// and any positive range stores them exactly.
fn largest(details: impl Iterator<Item = Details>) -> f32 {
    details
        .flatten()
        .fold(1.0 / 255.0, |largest, d| largest.max(d.abs()))
}

//! Search for the parameters of a plane by the measured error (thesis section 3.5.2).
//!
//! The transform is orthonormal, so the squared error of the details is that of the pixels, and the
//! low band, which is coded independently, does not matter here. The predictor has a closed form;
//! range and power curve are found by coordinate descent over a sample of the blocks. All levels share
//! the parameters, so the sample is of all levels.

use rayon::prelude::*;

use super::{
    blocks::{
        BlockFormat, BlockQuality, DetailEncoder, Starts, decode_blocks, encode_bc3, encode_bc4,
        encode_bc7,
    },
    haar::{Details, Transform},
    pack::low_weight,
    packing::Packing,
    plane::Plane,
    predict::{predicted, predictor_of, products, slopes},
    quality::level_weight,
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

/// Chooses how to store the levels of a plane in the wavelet packing `packing`, and returns an estimate of the mean
/// squared error in a pixel. `low_bounds` is the interval of the low band.
pub(super) fn choose_coding(
    levels: &[&CoefficientPlane],
    low_bounds: [f32; 2],
    packing: Packing,
    effort: Effort,
    predict: bool,
) -> (PlaneCoding, f64) {
    let mut coding = PlaneCoding::linear(low_bounds);
    let (gamma, zero_point) = match packing {
        Packing::Bc3 => (0.6, PlaneCoding::ZERO_POINT_565),
        _ => (0.86, PlaneCoding::ZERO_POINT_8),
    };
    coding.gamma = gamma;
    coding.zero_point = zero_point;
    coding.predictor = if predict { predictor(levels) } else { 0.0 };
    let largest = largest_of(levels, |details| details);
    coding.range = (USUAL_RANGE * (low_bounds[1] - low_bounds[0])).min(largest);
    // This range clamps nothing. It is larger than the largest detail because the zero point is
    // above the middle of the codes, which leaves a little less room for positive details.
    let all = 1.07 * largest;
    let (count, rounds) = match effort {
        Effort::Fast => return (coding, 0.0),
        Effort::Default => (512, 1),
        Effort::Best => (4096, 2),
    };
    let sample = sample(levels, coding.predictor, count);
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
    let estimate = match packing {
        Packing::Bc7 => joint_error(&sample, &coding),
        _ => known + low_error(&sample, &coding),
    };
    (coding, estimate / 4.0)
}

/// The same as the thesis does it: searches the transform, the clamping and the power curve,
/// without prediction.
pub(super) fn choose_thesis_coding(
    levels: &[&CoefficientPlane],
    low_bounds: [f32; 2],
    packing: Packing,
    effort: Effort,
) -> PlaneCoding {
    let coding = PlaneCoding::linear(low_bounds);
    if packing == Packing::Bc7 {
        let transform = Transform::PartiallyInvertedHaar { w: 0.0 };
        let stored = |details| {
            let [a, b, _] = transform.mix(details);
            [a, b, 0.0]
        };
        return PlaneCoding {
            transform,
            range: 0.74 * largest_of(levels, stored),
            gamma: 0.86,
            ..coding
        };
    }
    let candidate = |(transform, fraction, gamma): (Transform, f32, f32)| PlaneCoding {
        transform,
        range: fraction * largest_of(levels, |details| transform.mix(details)),
        gamma,
        ..coding
    };
    let mut best = (Transform::Haar, 0.55, 0.86);
    let (count, rounds) = match effort {
        Effort::Fast => return candidate(best),
        Effort::Default => (2048, 1),
        Effort::Best => (16384, 2),
    };
    let sample = sample(levels, 0.0, count);
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
        let gammas = [1.0, 0.86, 0.75, 0.65, 0.55];
        best = best_of(gammas.map(|g| (best.0, best.1, g)).to_vec());
        let scales = [0.88, 1.0, 1.14];
        best = best_of(scales.map(|s| (best.0, best.1 * s, best.2)).to_vec());
    }
    candidate(best)
}

fn least(errors: &[f64]) -> usize {
    (0..errors.len())
        .min_by(|&a, &b| errors[a].total_cmp(&errors[b]))
        .expect("there are candidates")
}

fn predictor(levels: &[&CoefficientPlane]) -> f32 {
    let mut sums = [0.0; 2];
    for (level, coefficients) in levels.iter().enumerate() {
        let [width, height] = coefficients.low_band.size;
        let of_row = |y: u32| {
            products((0..width).map(|x| {
                let slopes = slopes(&coefficients.low_band, x, y);
                (slopes, coefficients.details(x, y))
            }))
        };
        let rows: Vec<[f64; 2]> = (0..height).into_par_iter().map(of_row).collect();
        let weight = level_weight(level) / coefficients.details.len() as f64;
        for row in rows {
            sums = [0, 1].map(|i| sums[i] + weight * row[i]);
        }
    }
    predictor_of(sums)
}

/// One 4 x 4 block of coefficients.
struct Block {
    /// The details, without what is predicted.
    residual: [Details; 16],
    low: [f32; 16],
    /// The part of the pixels of all levels, as they are used, for which the block stands, over 16.
    weight: f64,
}

/// Blocks of all levels, more of those that are used more.
fn sample(levels: &[&CoefficientPlane], predictor: f32, count: usize) -> Vec<Block> {
    let total: f64 = (0..levels.len()).map(level_weight).sum();
    let of_level = |(level, coefficients): (usize, &&CoefficientPlane)| {
        let part = level_weight(level) / total;
        let count = (part * count as f64).round().max(1.0) as usize;
        let mut blocks = sample_of_level(coefficients, predictor, count);
        let weight = part / (16 * blocks.len()) as f64;
        blocks.iter_mut().for_each(|block| block.weight = weight);
        blocks
    };
    levels.iter().enumerate().flat_map(of_level).collect()
}

/// At most `count` blocks, evenly spaced among the blocks in the order of the energy of the residual, because a few
/// strong edges decide where clamping pays.
fn sample_of_level(coefficients: &CoefficientPlane, predictor: f32, count: usize) -> Vec<Block> {
    let [width, height] = coefficients.low_band.size;
    let columns = width.div_ceil(4);
    let total = columns as usize * height.div_ceil(4) as usize;
    let at = |block: usize, i: usize| {
        let (block, i) = (block as u32, i as u32);
        let x = (block % columns * 4 + i % 4).min(width - 1);
        let y = (block / columns * 4 + i / 4).min(height - 1);
        (x, y)
    };
    let residual = |block: usize| -> [Details; 16] {
        std::array::from_fn(|i| {
            let (x, y) = at(block, i);
            let prediction = predicted(&coefficients.low_band, x, y, predictor);
            let details = coefficients.details(x, y);
            std::array::from_fn(|c| details[c] - prediction[c])
        })
    };
    let block = |block: usize| Block {
        residual: residual(block),
        low: std::array::from_fn(|i| {
            let (x, y) = at(block, i);
            coefficients.low_band.clamped(x, y)
        }),
        weight: 0.0,
    };
    if total <= count {
        return (0..total).map(block).collect();
    }
    let energy = |b: usize| residual(b).iter().flatten().map(|d| d * d).sum::<f32>();
    let mut by_energy: Vec<(f32, usize)> =
        (0..total).into_par_iter().map(|b| (energy(b), b)).collect();
    by_energy.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let middle = |i: usize| by_energy[(2 * i + 1) * total / (2 * count)].1;
    (0..count).map(|i| block(middle(i))).collect()
}

fn details_error(sample: &[Block], coding: &PlaneCoding) -> f64 {
    let encoder = DetailEncoder::new(coding, Starts::One);
    let error = |block: &Block| block.weight * f64::from(encoder.block(&block.residual).1);
    sample.iter().map(error).sum()
}

/// The size of a texture with the blocks of a sample side by side.
fn texture(sample: &[Block]) -> [u32; 2] {
    [4 * sample.len() as u32, 4]
}

/// The block of a texel, and the texel's place in it.
fn at(sample: &[Block], x: u32, y: u32) -> (&Block, usize) {
    (&sample[(x / 4) as usize], (y * 4 + x % 4) as usize)
}

/// The same for all texels, row by row.
fn texels(sample: &[Block]) -> impl Iterator<Item = (&Block, usize)> {
    Plane::positions(texture(sample)).map(move |(x, y)| at(sample, x, y))
}

fn bc7_error(sample: &[Block], coding: &PlaneCoding, packing: Packing) -> f64 {
    let dropped = packing == Packing::Bc7;
    let blocks = encode_bc7(texture(sample), [1; 3], |x, y| {
        let (block, i) = at(sample, x, y);
        let [r, g, b] = coding.store_details(block.residual[i]);
        [r, g, if dropped { coding.zero_point[2] } else { b }]
    });
    let decoded = decode_blocks(BlockFormat::Bc7, &blocks, texture(sample));
    error_of_details(sample, coding, |texel| decoded[texel])
}

/// The error of details and low band together in BC7.
fn joint_error(sample: &[Block], coding: &PlaneCoding) -> f64 {
    let blocks = encode_bc7(texture(sample), [1, 1, low_weight(coding)], |x, y| {
        let (block, i) = at(sample, x, y);
        let [r, g, _] = coding.store_details(block.residual[i]);
        [r, g, coding.store_low(block.low[i])]
    });
    let decoded = decode_blocks(BlockFormat::Bc7, &blocks, texture(sample));
    let low = error_of_low(sample, coding, |texel| decoded[texel][2]);
    let details = |texel: usize| {
        let [r, g, ..] = decoded[texel];
        [r, g, coding.zero_point[2], 1.0]
    };
    low + error_of_details(sample, coding, details)
}

/// The error of the low band in BC4.
fn low_error(sample: &[Block], coding: &PlaneCoding) -> f64 {
    let stored = texels(sample).map(|(block, i)| coding.store_low(block.low[i]));
    let stored: Vec<f32> = stored.collect();
    let blocks = encode_bc4(&stored, texture(sample), BlockQuality::High);
    let decoded = decode_blocks(BlockFormat::Bc4, &blocks, texture(sample));
    error_of_low(sample, coding, |texel| decoded[texel][0])
}

fn error_of_low(sample: &[Block], coding: &PlaneCoding, stored: impl Fn(usize) -> f32) -> f64 {
    let errors = texels(sample).enumerate().map(|(texel, (block, i))| {
        // An error of the low band changes all four pixels.
        let error = f64::from(coding.load_low(stored(texel)) - block.low[i]);
        4.0 * block.weight * error * error
    });
    errors.sum()
}

fn mixed_error(sample: &[Block], coding: &PlaneCoding) -> f64 {
    let stored = texels(sample).map(|(block, i)| {
        let stored = coding.store_details(block.residual[i]);
        let [r, g, b] = stored.map(|v| (v * 255.0).round() as u8);
        [r, g, b, 255]
    });
    let stored: Vec<_> = stored.collect();
    let blocks = encode_bc3(&stored, texture(sample), BlockQuality::Normal);
    let decoded = decode_blocks(BlockFormat::Bc3, &blocks, texture(sample));
    error_of_details(sample, coding, |texel| decoded[texel])
}

fn error_of_details(
    sample: &[Block],
    coding: &PlaneCoding,
    stored: impl Fn(usize) -> [f32; 4],
) -> f64 {
    let errors = texels(sample).enumerate().map(|(texel, (block, i))| {
        let [r, g, b, _] = stored(texel);
        let (actual, expected) = (coding.load_details([r, g, b]), block.residual[i]);
        let error = (0..3).map(|c| f64::from(actual[c] - expected[c]).powi(2));
        block.weight * error.sum::<f64>()
    });
    errors.sum()
}

/// Largest magnitude over all channels and levels of what is stored of details. It has a lower limit because a flat
/// image has no details, and any positive range stores them exactly.
fn largest_of(levels: &[&CoefficientPlane], stored: impl Fn(Details) -> Details + Sync) -> f32 {
    let of_level = |coefficients: &&CoefficientPlane| {
        let details = coefficients.details.par_iter();
        let largest = details.map(|d| stored(*d).iter().fold(0.0, |a: f32, v| a.max(v.abs())));
        largest.reduce(|| 0.0, f32::max)
    };
    levels.iter().map(of_level).fold(1.0 / 255.0, f32::max)
}

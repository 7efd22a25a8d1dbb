//! The wavelets that the thesis compares, on values of 8 bits and with one packing: the scale
//! coefficient in alpha of BC3, the details in RGB with the best clamping and power curve (Table
//! 3.3).

use bevy_wavelet_tex::codec::{
    blocks::{BlockQuality, Texel, decode_bc3, encode_bc3},
    haar::{Coefficients, Transform, haar, inverse_haar},
};
use rayon::prelude::*;

use super::lossless;

/// A wavelet of 2 x 2 values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wavelet {
    /// Haar in real numbers, rounded to 8 bits (Eq. 3.15), partially inverted or not (Eq. 3.16).
    Real(Transform),
    /// The S-transform, in integers of 10 bits.
    S,
    /// PLHaar, in integers of 8 bits.
    PlHaar,
}

/// How the details of a plane are stored.
#[derive(Clone, Copy, Debug)]
struct Coding {
    wavelet: Wavelet,
    /// Largest detail in 8-bit units; larger ones are clamped.
    range: f32,
    /// Exponent of the power curve.
    gamma: f32,
}

/// Values `[a, b, c, d]` (a b above c d) in `0..=255`.
type Quad = [i32; 4];

/// The 4 x 4 quads of one block.
type Block = [Quad; 16];

/// Largest number of blocks that the search for the parameters uses.
const SAMPLE: usize = 512;

/// Encodes and decodes a plane of values in `0..=255`, whose sides are multiples of 8.
pub fn through(family: &[Wavelet], plane: &[i32], size: [usize; 2]) -> Vec<f32> {
    let [width, height] = size;
    let columns = width / 8;
    let position = |block: usize, texel: usize| {
        let x = 2 * (block % columns * 4 + texel % 4);
        let y = 2 * (block / columns * 4 + texel / 4);
        y * width + x
    };
    let blocks: Vec<Block> = (0..columns * height / 8)
        .map(|block| {
            std::array::from_fn(|texel| {
                let i = position(block, texel);
                [
                    plane[i],
                    plane[i + 1],
                    plane[i + width],
                    plane[i + width + 1],
                ]
            })
        })
        .collect();
    let every = blocks.len().div_ceil(SAMPLE);
    let sample: Vec<Block> = blocks.iter().step_by(every).copied().collect();
    let coding = best_coding(family, &sample);
    let decoded = decoded(&coding, &blocks, BlockQuality::High);
    let mut back = vec![0.0; plane.len()];
    for (i, quad) in decoded.iter().enumerate() {
        let first = position(i / 16, i % 16);
        for (offset, value) in [0, 1, width, width + 1].into_iter().zip(quad) {
            back[first + offset] = *value;
        }
    }
    back
}

/// Searches the best wavelet, range and power curve, one after the other.
fn best_coding(family: &[Wavelet], sample: &[Block]) -> Coding {
    let largest = |wavelet: Wavelet| {
        let details = sample.iter().flatten().flat_map(|q| wavelet.forward(*q).1);
        details.fold(1.0, |most: f32, d| most.max(d.abs()))
    };
    let with_wavelet = |wavelet: &Wavelet, fraction: f32, gamma: f32| Coding {
        wavelet: *wavelet,
        range: fraction * largest(*wavelet),
        gamma,
    };
    let best_of = |candidates: Vec<Coding>| {
        let errors: Vec<f64> = candidates.par_iter().map(|c| error(c, sample)).collect();
        let best = (0..errors.len()).min_by(|&a, &b| errors[a].total_cmp(&errors[b]));
        candidates[best.expect("there are candidates")]
    };
    let all = family.iter().map(|w| with_wavelet(w, 0.55, 0.86));
    let mut coding = best_of(all.collect());
    for fractions in [&[2.0, 1.4, 1.0, 0.74, 0.55, 0.4][..], &[0.88, 1.0, 1.14]] {
        let scaled = |s: &f32| Coding {
            range: coding.range * s,
            ..coding
        };
        coding = best_of(fractions.iter().map(scaled).collect());
        let curved = |gamma: f32| Coding { gamma, ..coding };
        coding = best_of([1.0, 0.86, 0.75, 0.65, 0.55].map(curved).to_vec());
    }
    coding
}

fn error(coding: &Coding, sample: &[Block]) -> f64 {
    let pairs = sample
        .iter()
        .flatten()
        .zip(decoded(coding, sample, BlockQuality::Normal));
    let of_quad = |(wanted, got): (&Quad, [f32; 4])| -> f64 {
        let pairs = wanted.iter().zip(got);
        pairs.map(|(w, g)| f64::from(*w as f32 - g).powi(2)).sum()
    };
    pairs.map(of_quad).sum()
}

/// Encodes and decodes blocks and returns their quads, block by block.
fn decoded(coding: &Coding, blocks: &[Block], quality: BlockQuality) -> Vec<[f32; 4]> {
    // The blocks are side by side in one row, so the texels are stored row by row across all
    // blocks.
    let size = [4 * blocks.len() as u32, 4];
    let at = |row: usize, column: usize| blocks[column / 4][row * 4 + column % 4];
    let texels: Vec<Texel> = (0..4)
        .flat_map(|row| (0..4 * blocks.len()).map(move |column| (row, column)))
        .map(|(row, column)| coding.store(at(row, column)))
        .collect();
    let texels = decode_bc3(&encode_bc3(&texels, size, quality), size);
    let position = |i: usize| {
        let (block, texel) = (i / 16, i % 16);
        texel / 4 * 4 * blocks.len() + block * 4 + texel % 4
    };
    (0..16 * blocks.len())
        .map(|i| coding.load(texels[position(i)]))
        .collect()
}

impl Wavelet {
    /// Transforms a quad to its scale coefficient, in `0..=255`, and its details.
    fn forward(self, quad: Quad) -> (f32, [f32; 3]) {
        let lossless = |step| {
            let [ll, details @ ..] = lossless::forward(step, quad.map(|v| v - 128));
            ((ll + 128) as f32, details.map(|d| d as f32))
        };
        match self {
            Self::Real(transform) => {
                let coefficients = haar(quad.map(|v| v as f32));
                let mean = coefficients.ll / 2.0;
                (mean, transform.mix(coefficients.details))
            }
            Self::S => lossless(lossless::s_transform),
            Self::PlHaar => lossless(lossless::pl_haar),
        }
    }

    fn inverse(self, scale: f32, details: [f32; 3]) -> [f32; 4] {
        match self {
            Self::Real(transform) => inverse_haar(Coefficients {
                ll: 2.0 * scale,
                details: transform.unmix(details),
            }),
            Self::S | Self::PlHaar => {
                let step = match self {
                    Self::S => lossless::inverse_s_transform,
                    _ => lossless::inverse_pl_haar,
                };
                let [h, v, d] = details.map(|d| d.round() as i32);
                let coefficients = [scale.round() as i32 - 128, h, v, d];
                // PLHaar is defined for 8 bits only, and the stored values had no more.
                let coefficients = match self {
                    Self::PlHaar => coefficients.map(|c| c.clamp(-128, 127)),
                    _ => coefficients,
                };
                lossless::inverse(step, coefficients).map(|v| (v + 128) as f32)
            }
        }
    }
}

impl Coding {
    fn store(&self, quad: Quad) -> Texel {
        let (scale, details) = self.wavelet.forward(quad);
        let [r, g, b] = details.map(|d| {
            let normalized = (d / self.range).clamp(-1.0, 1.0);
            let curved = normalized.abs().powf(self.gamma).copysign(normalized);
            128.0 + 127.0 * curved
        });
        [r, g, b, scale].map(|v| v.round().clamp(0.0, 255.0) as u8)
    }

    fn load(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        let details = [r, g, b].map(|v| {
            let curved = (255.0 * v - 128.0) / 127.0;
            self.range * curved.abs().powf(1.0 / self.gamma).copysign(curved)
        });
        self.wavelet.inverse(255.0 * a, details)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wavelet_brings_a_slope_back() {
        // BC1 has 4 colours for the 4 quads of a row, so almost nothing but rounding errors is
        // lost.
        let size = [16, 16];
        let plane: Vec<i32> = (0..256).map(|i| 60 + 4 * (i % 16) + 3 * (i / 16)).collect();
        let partly = Transform::PartiallyInvertedHaar { w: 0.4 };
        for wavelet in [
            Wavelet::Real(Transform::Haar),
            Wavelet::Real(partly),
            Wavelet::S,
            Wavelet::PlHaar,
        ] {
            let back = through(&[wavelet], &plane, size);
            let pairs = plane.iter().zip(back);
            let worst = pairs
                .map(|(a, b)| (*a as f32 - b).abs())
                .fold(0.0, f32::max);
            assert!(worst <= 6.0, "{wavelet:?}: {worst}");
        }
    }
}

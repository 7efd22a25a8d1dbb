//! Resolve of the samples of a multisampled pixel.
//!
//! All samples of a pixel store the same kind of chrominance (thesis 4.7.1), so they can be averaged
//! before the reconstruction. Those of the 8-bit format are gamma-encoded: their mean is that of an edge that is too
//! dark, so it serves the reconstruction only, and the colours of the samples are averaged in linear light.

use super::{color::linear_from_srgb, pack::PackedPixel, reconstruct::decode};
use crate::settings::MsaaResolve;

/// Resolves the samples of a pixel; without samples, the result is black.
pub fn resolved(samples: &[PackedPixel], resolve: MsaaResolve) -> PackedPixel {
    let mut sum = PackedPixel::default();
    let mut weights = 0.0;
    for sample in samples {
        let weight = match resolve {
            MsaaResolve::Box => 1.0,
            MsaaResolve::ToneMapWeighted => 1.0 / (1.0 + sample.luminance.max(0.0)),
        };
        sum.luminance += weight * sample.luminance;
        sum.chrominance += weight * sample.chrominance;
        weights += weight;
    }
    if weights == 0.0 {
        return PackedPixel::default();
    }
    PackedPixel {
        luminance: sum.luminance / weights,
        chrominance: sum.chrominance / weights,
    }
}

/// Returns the display-linear mean of the samples of a pixel in the 8-bit format. `missing_ratio` is the missing
/// chrominance of the pixel, relative to its luminance; `is_co` tells whether the pixel stores Co.
pub fn mean_in_linear_light(samples: &[PackedPixel], missing_ratio: f32, is_co: bool) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for sample in samples {
        let encoded = decode(*sample, missing_ratio * sample.luminance, is_co);
        for (sum, channel) in sum.iter_mut().zip(encoded) {
            *sum += linear_from_srgb(channel.clamp(0.0, 1.0)) / samples.len() as f32;
        }
    }
    sum
}

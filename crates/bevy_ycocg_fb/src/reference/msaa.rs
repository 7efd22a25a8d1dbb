//! Resolve of the samples of a multisampled pixel.
//!
//! All samples of a pixel store the same kind of chrominance (thesis 4.7.1), so they can be averaged
//! before the reconstruction.

use super::pack::PackedPixel;
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

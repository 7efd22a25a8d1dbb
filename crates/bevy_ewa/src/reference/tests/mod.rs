//! Properties that hold for every texture, footprint and method.

mod extremes;
mod filters;
mod footprints;
mod pictures;

use super::*;
use crate::settings::*;

pub(super) const EXACT: [EwaMethod; 3] =
    [EwaMethod::Reference, EwaMethod::Linear, EwaMethod::Bilinear];

const FIVE: EwaProbes = EwaProbes::Five;

pub(super) const METHODS: [EwaMethod; 9] = [
    EwaMethod::Reference,
    EwaMethod::Linear,
    EwaMethod::Bilinear,
    EwaMethod::Approximate { probes: FIVE },
    EwaMethod::Spatial { probes: FIVE },
    EwaMethod::Temporal { probes: FIVE },
    EwaMethod::SpatialTemporal { probes: FIVE },
    EwaMethod::SoftwareAnisotropic,
    EwaMethod::Hardware,
];

pub(super) const KERNELS: [EwaKernel; 5] = [
    EwaKernel::Box,
    EwaKernel::Tent,
    EwaKernel::Gaussian { sigma_pixels: 0.5 },
    EwaKernel::MitchellNetravali,
    EwaKernel::Lanczos,
];

/// A texture of noise that is the same in every run.
pub(super) fn noise(size: [u32; 2]) -> Texture {
    Texture::from_fn(size, |x, y| {
        let mut hash = u64::from(x) << 32 | u64::from(y);
        [0, 1, 2, 3].map(|_| {
            hash = (hash ^ hash >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            hash = hash.wrapping_add(0x9e37_79b9_7f4a_7c15);
            (hash >> 40) as f64 / f64::from(1 << 24)
        })
    })
}

/// Returns derivatives whose footprint has these radii in texture coordinates, with the major axis at an
/// angle to u.
pub(super) fn ellipse(major: f64, minor: f64, angle: f64) -> Derivatives {
    let (sin, cos) = angle.sin_cos();
    Derivatives {
        dx: [major * cos, major * sin],
        dy: [-minor * sin, minor * cos],
    }
}

/// Returns the largest absolute difference over the channels.
pub(super) fn difference(a: Sampled, b: Sampled) -> f64 {
    let pairs = a.color.iter().zip(b.color);
    pairs.fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

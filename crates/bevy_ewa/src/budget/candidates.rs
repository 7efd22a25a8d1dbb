//! The candidate settings, with their measured errors and costs.

use crate::settings::{EwaMethod, EwaProbes, EwaSettings};

/// A candidate with its measured error and cost. A test repeats the measurements
/// (`cargo test -p bevy_ewa --no-default-features --lib budget -- --nocapture` prints the rows).
///
/// The two figures of a pair are for samplers without anisotropy, where the shader computes the probes,
/// and with 16x, where they are the texture unit's, modelled by [`EwaMethod::SoftwareAnisotropic`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Value of [`EwaSettings::method`].
    pub method: EwaMethod,
    /// Value of [`EwaSettings::max_anisotropy`].
    pub max_anisotropy: f32,
    /// Value of [`EwaSettings::max_fetches`].
    pub max_fetches: u32,
    /// Mean squared error against exact EWA in 8-bit sRGB units, averaged over the scenes.
    pub errors: [f32; 2],
    /// Mean fetches per pixel in the scene that takes most.
    pub fetches: [f32; 2],
}

impl Candidate {
    /// Returns `base` with the values of this candidate.
    pub fn settings(&self, base: EwaSettings) -> EwaSettings {
        EwaSettings {
            method: self.method,
            max_anisotropy: self.max_anisotropy,
            max_fetches: self.max_fetches,
            ..base
        }
    }

    /// Returns the error on samplers of this anisotropy.
    pub fn error(&self, sampler_anisotropy: u16) -> f32 {
        self.errors[index(sampler_anisotropy)]
    }

    /// Returns the mean fetches per pixel on samplers of this anisotropy.
    pub fn mean_fetches(&self, sampler_anisotropy: u16) -> f32 {
        self.fetches[index(sampler_anisotropy)]
    }
}

fn index(sampler_anisotropy: u16) -> usize {
    usize::from(sampler_anisotropy > 1)
}

const fn exact(method: EwaMethod, max_fetches: u32, error: f32, fetches: f32) -> Candidate {
    Candidate {
        method,
        max_anisotropy: 32.0,
        max_fetches,
        errors: [error; 2],
        fetches: [fetches; 2],
    }
}

const fn probes(method: EwaMethod, errors: [f32; 2], fetches: [f32; 2]) -> Candidate {
    Candidate {
        method,
        max_anisotropy: 32.0,
        max_fetches: 2048,
        errors,
        fetches,
    }
}

use EwaMethod::{Anisotropic, Approximate, Bilinear, Linear, SoftwareAnisotropic, Spatial};
use EwaProbes::{ByAspect, Five, Seven, Three};

/// The candidates: exact methods, down to coarse mip levels, and probes.
pub const CANDIDATES: [Candidate; 19] = [
    exact(Linear, 2048, 0.0, 199.3),
    exact(Linear, 1024, 0.2, 104.6),
    exact(Linear, 512, 2.1, 51.3),
    exact(Linear, 256, 12.7, 25.1),
    exact(Linear, 128, 58.5, 12.2),
    exact(Linear, 64, 225.9, 5.5),
    exact(Bilinear, 2048, 0.1, 127.9),
    exact(Bilinear, 1024, 1.0, 63.1),
    exact(Bilinear, 512, 3.8, 32.5),
    exact(Bilinear, 256, 12.8, 16.3),
    exact(Bilinear, 128, 68.2, 8.0),
    probes(Approximate { probes: Seven }, [4.4; 2], [56.0, 7.0]),
    probes(Approximate { probes: Five }, [7.8; 2], [50.0, 5.0]),
    probes(Approximate { probes: Three }, [25.3; 2], [45.0, 3.0]),
    probes(Approximate { probes: ByAspect }, [9.3; 2], [54.0, 9.0]),
    probes(Spatial { probes: Five }, [32.7; 2], [50.0, 5.0]),
    probes(Spatial { probes: Three }, [37.5; 2], [45.0, 3.0]),
    probes(SoftwareAnisotropic, [98.1; 2], [16.0; 2]),
    probes(Anisotropic, [98.1; 2], [1.0; 2]),
];

//! What settings cost: the candidates with their measured errors and costs, and an upper bound of a lookup's cost.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::{
    reference::{
        footprint::{Footprint, max_texels},
        probes,
    },
    settings::{EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings},
};

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

const fn candidate(
    method: EwaMethod,
    max_fetches: u32,
    errors: [f32; 2],
    fetches: [f32; 2],
) -> Candidate {
    Candidate {
        method,
        max_anisotropy: 32.0,
        max_fetches,
        errors,
        fetches,
    }
}

/// The candidates: exact methods, down to coarse mip levels, and probes.
pub const CANDIDATES: [Candidate; 19] = {
    use EwaMethod::{Anisotropic, Approximate, Bilinear, Linear, SoftwareAnisotropic, Spatial};
    use EwaProbes::{ByAspect, Five, Seven, Three};
    [
        candidate(Linear, 2048, [0.0; 2], [199.3; 2]),
        candidate(Linear, 1024, [0.2; 2], [104.6; 2]),
        candidate(Linear, 512, [2.1; 2], [51.3; 2]),
        candidate(Linear, 256, [12.7; 2], [25.1; 2]),
        candidate(Linear, 128, [58.5; 2], [12.2; 2]),
        candidate(Linear, 64, [225.9; 2], [5.5; 2]),
        candidate(Bilinear, 2048, [0.1; 2], [127.9; 2]),
        candidate(Bilinear, 1024, [1.0; 2], [63.1; 2]),
        candidate(Bilinear, 512, [3.8; 2], [32.5; 2]),
        candidate(Bilinear, 256, [12.8; 2], [16.3; 2]),
        candidate(Bilinear, 128, [68.2; 2], [8.0; 2]),
        candidate(Approximate { probes: Seven }, 2048, [4.4; 2], [56.0, 7.0]),
        candidate(Approximate { probes: Five }, 2048, [7.8; 2], [50.0, 5.0]),
        candidate(Approximate { probes: Three }, 2048, [25.3; 2], [45.0, 3.0]),
        candidate(
            Approximate { probes: ByAspect },
            2048,
            [9.3; 2],
            [54.0, 9.0],
        ),
        candidate(Spatial { probes: Five }, 2048, [32.7; 2], [50.0, 5.0]),
        candidate(Spatial { probes: Three }, 2048, [37.5; 2], [45.0, 3.0]),
        candidate(SoftwareAnisotropic, 2048, [98.1; 2], [16.0; 2]),
        candidate(Anisotropic, 2048, [98.1; 2], [1.0; 2]),
    ]
};

/// Returns the number of texture fetches that no lookup with these settings exceeds, for any derivatives.
pub fn worst_case_fetches(settings: &EwaSettings) -> f32 {
    let settings = settings.clamped();
    let max_aspect = f64::from(settings.max_anisotropy);
    let threshold = f64::from(settings.spatial_threshold);
    let fetches = match settings.method {
        EwaMethod::Reference | EwaMethod::Linear | EwaMethod::Bilinear => exact_fetches(&settings),
        EwaMethod::Approximate { probes } | EwaMethod::Temporal { probes } => {
            approximate(&settings, probes, max_aspect)
        }
        // In the blend around the threshold, both are fetched.
        EwaMethod::Spatial { probes } | EwaMethod::SpatialTemporal { probes } => {
            let single = single_probe(&settings, threshold.min(max_aspect));
            let blended = single + approximate(&settings, probes, threshold.min(max_aspect));
            blended.max(approximate(&settings, probes, max_aspect))
        }
        EwaMethod::SoftwareAnisotropic => probes::MAX_TAPS,
        EwaMethod::Stochastic | EwaMethod::Anisotropic | EwaMethod::Hardware => 1.0,
    };
    fetches as f32
}

/// The texels of an ellipse with the longest axes, in the finer and the coarser level that are
/// blended, or `max_fetches` if that is lower, as it raises the level of detail.
fn exact_fetches(settings: &EwaSettings) -> f64 {
    // The additional fetch is the bilinear one that magnification blends in.
    let bound = f64::from(settings.max_fetches) + 1.0;
    let minor = f64::from(settings.minor_radius_texels);
    let levels: &[f64] = if settings.level_blend > 0.0 {
        &[2.0, 1.0]
    } else {
        &[2.0]
    };
    // The formula of texture units divides by their number of taps, which can choose a finer level than
    // the loop below assumes.
    if settings.level_of_detail != EwaLevelOfDetail::MinorRadius {
        return bound;
    }
    let mut fetches = 1.0;
    for level in levels {
        let minor = level * minor;
        let major = f64::from(settings.max_anisotropy) * minor;
        let texels = max_texels(major + 1.0, minor + 1.0);
        // A row of an odd number of texels has one that is fetched alone. Rows run along the longer side
        // of the bounding box, so there are most of them where its sides are equal.
        let rows = 2.0 * (FRAC_1_SQRT_2 * major.hypot(minor)).hypot(1.0) + 1.0;
        let pairs = settings.method == EwaMethod::Linear && !has_negative_lobes(settings);
        fetches += if pairs { (texels + rows) / 2.0 } else { texels };
    }
    fetches.min(bound)
}

/// Whether the kernel has negative weights: pairs of texels with one negative weight are fetched one by
/// one.
fn has_negative_lobes(settings: &EwaSettings) -> bool {
    matches!(
        settings.kernel,
        EwaKernel::Lanczos | EwaKernel::MitchellNetravali
    )
}

/// The most fetches of `Approximate` for ellipses up to this aspect. Where probes are computed, the taps
/// per probe grow with the aspect until the ellipse gets another pair of probes.
fn approximate(settings: &EwaSettings, probes: EwaProbes, aspect: f64) -> f64 {
    let multiples = (1..).map(|multiple| f64::from(multiple) * probes::ASPECT_PER_PROBE_PAIR);
    let maxima = multiples.take_while(|end| *end < aspect).chain([aspect]);
    let fetches = maxima.map(|aspect| {
        let count = probes::probe_count(probes, aspect);
        f64::from(count) * probes::probe_fetches(&ellipse(aspect), settings, count)
    });
    fetches.fold(0.0, f64::max)
}

fn single_probe(settings: &EwaSettings, aspect: f64) -> f64 {
    probes::single_probe_fetches(&ellipse(aspect), settings)
}

/// An ellipse so large that no probe has fewer taps because its width is limited to one texel.
fn ellipse(aspect: f64) -> Footprint {
    Footprint {
        major_radius_texels: 1e3 * aspect,
        minor_radius_texels: 1e3,
        major_direction: [1.0, 0.0],
        anisotropy: aspect,
        hardware_lod: 0.0,
    }
}

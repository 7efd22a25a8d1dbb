//! An upper bound of the cost of a lookup.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::{
    reference::{
        footprint::{Footprint, max_texels},
        probes,
    },
    settings::{EwaMethod, EwaProbes, EwaSettings},
};

/// Returns the number of texture fetches that no lookup with these settings exceeds, for any derivatives.
pub fn worst_case_fetches(settings: &EwaSettings) -> f32 {
    let settings = settings.clamped();
    let max_aspect = f64::from(settings.max_anisotropy);
    let threshold = f64::from(settings.spatial_threshold);
    let fetches = match settings.method {
        EwaMethod::Reference | EwaMethod::Linear | EwaMethod::Bilinear => exact(&settings),
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
fn exact(settings: &EwaSettings) -> f64 {
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
    if settings.level_of_detail != crate::EwaLevelOfDetail::MinorRadius {
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
    use crate::EwaKernel::{Lanczos, MitchellNetravali};
    matches!(settings.kernel, Lanczos | MitchellNetravali)
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

//! A lookup by any method.

use super::{
    exact::exact,
    footprint::{Derivatives, Footprint},
    probes::{ProbeSubset, approximate, single_probe, software_anisotropic},
    stochastic::{noise, stochastic},
    texture::{Color, Texture, mix},
};
use crate::settings::{EwaMethod, EwaProbes, EwaSettings};

/// Texture coordinates below which 32-bit floats are precise enough without a reduction by whole
/// periods.
const MAX_PRECISE_UV: f64 = 16.0;

/// A filtered colour and the cost of its lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled {
    /// Filtered colour in linear light.
    pub color: Color,
    /// Number of texture fetches: of one texel, bilinear, trilinear or, when `sampler_anisotropy` is
    /// above 1, by the texture unit's anisotropic filter.
    pub fetches: u32,
}

/// Filters a texture at a point.
///
/// `frame` is the frame number, which the temporal and the stochastic methods use. Texture coordinates that are not finite
/// count as 0.
pub fn sample(
    texture: &Texture,
    uv: [f64; 2],
    derivatives: Derivatives,
    settings: &EwaSettings,
    frame: u32,
) -> Sampled {
    texture.take_fetches();
    let settings = settings.clamped();
    let noise = noise(uv, frame);
    let uv = uv.map(|c| wrapped(c, settings.periodic));
    let max_anisotropy = f64::from(settings.max_anisotropy);
    let footprint = Footprint::new(derivatives, texture.size(), max_anisotropy);
    let approximated =
        |probes, subset| approximate(texture, &footprint, uv, &settings, probes, subset);
    let single = || single_probe(texture, &footprint, uv, &settings);
    let spatial = |probes: EwaProbes, subset: ProbeSubset| {
        let threshold = f64::from(settings.spatial_threshold);
        let fraction = (footprint.anisotropy - threshold + 1.0).clamp(0.0, 1.0);
        if fraction <= 0.0 {
            single()
        } else if fraction >= 1.0 {
            approximated(probes, subset)
        } else {
            mix(single(), approximated(probes, subset), fraction)
        }
    };
    let subset = if frame.is_multiple_of(2) {
        ProbeSubset::Even
    } else {
        ProbeSubset::Odd
    };
    let color = match settings.method {
        EwaMethod::Reference | EwaMethod::Linear | EwaMethod::Bilinear => {
            exact(texture, &footprint, uv, &settings)
        }
        EwaMethod::Approximate { probes } => approximated(probes, ProbeSubset::All),
        EwaMethod::Temporal { probes } => approximated(probes, subset),
        EwaMethod::Spatial { probes } => spatial(probes, ProbeSubset::All),
        EwaMethod::SpatialTemporal { probes } => spatial(probes, subset),
        // A texture unit's filter, as the specification has it.
        EwaMethod::SoftwareAnisotropic | EwaMethod::Anisotropic => {
            software_anisotropic(texture, [derivatives.dx, derivatives.dy], uv)
        }
        EwaMethod::Stochastic => stochastic(texture, &footprint, uv, &settings, noise),
        EwaMethod::Hardware => trilinear(texture, derivatives, uv),
    };
    Sampled {
        color,
        fetches: texture.take_fetches(),
    }
}

/// Filters as a sampler without anisotropy does.
fn trilinear(texture: &Texture, derivatives: Derivatives, uv: [f64; 2]) -> Color {
    let size = texture.size();
    let length = |d: [f64; 2]| (d[0] * f64::from(size[0])).hypot(d[1] * f64::from(size[1]));
    let longer = length(derivatives.dx).max(length(derivatives.dy));
    let lod = if longer.is_finite() {
        longer.max(1e-12).log2()
    } else {
        f64::from(texture.last_level())
    };
    texture.trilinear(uv, lod)
}

/// Reduces a texture coordinate by whole periods. A period is two textures wide, so that it also holds
/// for textures that mirror.
fn wrapped(c: f64, periodic: bool) -> f64 {
    if !c.is_finite() {
        0.0
    } else if periodic && c.abs() > MAX_PRECISE_UV {
        c - 2.0 * (c / 2.0).floor()
    } else {
        c.clamp(-1e6, 1e6)
    }
}

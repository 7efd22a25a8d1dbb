//! A lookup by any method.

use super::{
    exact::exact,
    footprint::{Derivatives, Footprint},
    probes::{Turn, approximate, single, software_anisotropic},
    texture::{Color, Texture, mix},
};
use crate::settings::{EwaMethod, EwaProbes, EwaSettings};

/// Texture coordinates below which 32-bit floats are precise enough without a reduction by whole
/// periods.
const PRECISE_UV: f64 = 16.0;

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
/// `frame` is the frame number, which the temporal methods use. Texture coordinates that are not finite
/// count as 0.
pub fn sample(
    texture: &Texture,
    uv: [f64; 2],
    derivatives: Derivatives,
    settings: &EwaSettings,
    frame: u32,
) -> Sampled {
    texture.take_fetches();
    let settings = settings.sanitized();
    let uv = uv.map(|c| reduced(c, settings.periodic));
    let max_anisotropy = f64::from(settings.max_anisotropy);
    let footprint = Footprint::new(derivatives, texture.size(), max_anisotropy);
    let probed = |probes, turn| approximate(texture, &footprint, uv, &settings, probes, turn);
    let one = || single(texture, &footprint, uv, &settings);
    let spatial = |probes: EwaProbes, turn: Turn| {
        let threshold = f64::from(settings.spatial_threshold);
        let part = (footprint.anisotropy - threshold + 1.0).clamp(0.0, 1.0);
        if part <= 0.0 {
            one()
        } else if part >= 1.0 {
            probed(probes, turn)
        } else {
            mix(one(), probed(probes, turn), part)
        }
    };
    let turn = if frame.is_multiple_of(2) {
        Turn::Even
    } else {
        Turn::Odd
    };
    let color = match settings.method {
        EwaMethod::Reference | EwaMethod::Linear | EwaMethod::Bilinear => {
            exact(texture, &footprint, uv, &settings)
        }
        EwaMethod::Approximate { probes } => probed(probes, Turn::All),
        EwaMethod::Temporal { probes } => probed(probes, turn),
        EwaMethod::Spatial { probes } => spatial(probes, Turn::All),
        EwaMethod::SpatialTemporal { probes } => spatial(probes, turn),
        EwaMethod::SoftwareAnisotropic => {
            software_anisotropic(texture, [derivatives.dx, derivatives.dy], uv)
        }
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
fn reduced(c: f64, periodic: bool) -> f64 {
    if !c.is_finite() {
        0.0
    } else if periodic && c.abs() > PRECISE_UV {
        c - 2.0 * (c / 2.0).floor()
    } else {
        c.clamp(-1e6, 1e6)
    }
}

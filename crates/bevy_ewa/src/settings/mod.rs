//! Settings of the filter, for one material or for all materials.
//!
//! | module | contents |
//! | --- | --- |
//! | `method` | the filtering methods |
//! | `kernel` | the reconstruction filters, and the formulas of the mip level |
//! | `maps` | the maps of a material |

mod kernel;
mod maps;
mod method;

#[cfg(feature = "bevy")]
use bevy::prelude::*;

pub use kernel::{EwaKernel, EwaLevelOfDetail};
pub use maps::EwaMaps;
pub use method::{EwaMethod, EwaProbes};

/// The settings by which a texture is filtered.
///
/// Values outside their range are clamped to it; NaN becomes the default.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub struct EwaSettings {
    /// The filtering method, from reference quality to nearly the speed of the texture unit. Default:
    /// [`EwaMethod::Linear`].
    pub method: EwaMethod,
    /// The maps of Bevy's materials that are filtered by the method; the texture unit filters the others. A map that
    /// a material lacks costs nothing. Default: base colour, emissive and normals.
    pub maps: EwaMaps,
    /// The reconstruction filter of a pixel on the screen. Default: a Gaussian with a standard
    /// deviation of half a pixel (thesis 5.6).
    pub kernel: EwaKernel,
    /// Upper limit of the ratio of the ellipse's axes. Ellipses below the limit are unchanged; longer
    /// ones get a wider minor axis. Higher values are sharper and cost more. 1 to 1024, default 32
    /// (thesis table 5.1).
    pub max_anisotropy: f32,
    /// Minimum length of the ellipse's minor radius, in texels of the chosen mip level: T_pp in thesis
    /// equation 5.3. The actual length is less than twice the minimum. Higher values are sharper and
    /// cost more. 0.5 to 4, default 1.5.
    pub minor_radius_texels: f32,
    /// The formula that chooses the mip level. Default: [`EwaLevelOfDetail::MinorRadius`].
    pub level_of_detail: EwaLevelOfDetail,
    /// Fraction of the interval between two mip levels in which both are read and blended. 0 reads a
    /// single level everywhere, as in the thesis, with a visible step where the level changes; 1 blends
    /// everywhere and costs most. 0 to 1, default 0.25. It affects the exact methods only; probes are
    /// trilinear.
    pub level_blend: f32,
    /// Upper limit of the texture fetches of one lookup by an exact method. Where the ellipse needs
    /// more, a coarser mip level is read; the ellipse is never cut. 16 to 4096, default 2048.
    pub max_fetches: u32,
    /// Anisotropy above which [`EwaMethod::Spatial`] replaces its single probe by several, alpha_0 in
    /// thesis 5.5.1. Lower values take several probes, and so more fetches, for more pixels. 2 to 1024,
    /// default 16, where the texture unit reaches its limit.
    pub spatial_threshold: f32,
    /// The `anisotropy_clamp` of the samplers of those textures that the texture unit filters. Above 1, the plugin
    /// raises it for the textures of Bevy's materials, and each probe is one fetch by the texture unit; at 1, the
    /// samplers stay as they are, and the shader computes the probes as a texture unit with 16x anisotropy would.
    /// Exact methods apply it to the maps that [`EwaSettings::maps`] leaves out. 1 to 16, default 1, which
    /// [`EwaMethod::Anisotropic`] takes for 16. Samplers that filter otherwise than linearly stay as they are.
    pub sampler_anisotropy: u16,
    /// Whether the textures repeat or mirror, so that texture coordinates beyond 16 can be reduced
    /// by whole periods and stay precise. For Bevy's materials it is switched off automatically where
    /// the sampler of a texture clamps. In custom shaders, switch it off for clamped textures that are
    /// sampled at such large coordinates. Default: true.
    pub periodic: bool,
}

impl Default for EwaSettings {
    fn default() -> Self {
        Self {
            method: EwaMethod::default(),
            maps: EwaMaps::default(),
            kernel: EwaKernel::default(),
            max_anisotropy: 32.0,
            minor_radius_texels: 1.5,
            level_of_detail: EwaLevelOfDetail::default(),
            level_blend: 0.25,
            max_fetches: 2048,
            spatial_threshold: 16.0,
            sampler_anisotropy: 1,
            periodic: true,
        }
    }
}

impl EwaSettings {
    /// Returns the default settings with another method.
    pub fn with_method(method: EwaMethod) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }

    /// Returns the anisotropy of samplers that the settings ask for, from 1 to 16.
    pub fn texture_unit_anisotropy(&self) -> u16 {
        match (self.method, self.sampler_anisotropy) {
            (EwaMethod::Anisotropic, 0 | 1) => 16,
            (EwaMethod::Hardware, _) => 1,
            (_, anisotropy) => anisotropy.clamp(1, 16),
        }
    }

    /// Returns the settings with every value clamped to its range.
    pub fn clamped(self) -> Self {
        let default = Self::default();
        let within = |value: f32, default: f32, low: f32, high: f32| {
            if value.is_nan() {
                default
            } else {
                value.clamp(low, high)
            }
        };
        let kernel = match self.kernel {
            EwaKernel::Gaussian { sigma_pixels } => EwaKernel::Gaussian {
                sigma_pixels: within(sigma_pixels, 0.5, 0.05, 2.0),
            },
            kernel => kernel,
        };
        Self {
            kernel,
            max_anisotropy: within(self.max_anisotropy, default.max_anisotropy, 1.0, 1024.0),
            minor_radius_texels: within(
                self.minor_radius_texels,
                default.minor_radius_texels,
                0.5,
                4.0,
            ),
            level_blend: within(self.level_blend, default.level_blend, 0.0, 1.0),
            max_fetches: self.max_fetches.clamp(16, 4096),
            spatial_threshold: within(
                self.spatial_threshold,
                default.spatial_threshold,
                2.0,
                1024.0,
            ),
            sampler_anisotropy: self.sampler_anisotropy.clamp(1, 16),
            ..self
        }
    }
}

//! The filters as WESL modules, which any shader can import.
//!
//! `ewa.wesl` has the functions to call, and `types.wesl` the settings that they take. The CPU reference
//! of each of the other modules is the module of the same name in [`reference`](mod@crate::reference).

use bevy::render::render_resource::ShaderType;

use crate::settings::{EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings};

/// The struct `EwaSettings` of `types.wesl`, for the uniform buffer of a custom material.
#[derive(Clone, Copy, Debug, PartialEq, ShaderType)]
#[allow(missing_docs)] // The fields are documented in `types.wesl`.
pub struct EwaUniform {
    pub method: u32,
    pub probes: u32,
    pub kernel: u32,
    pub level_of_detail: u32,
    pub kernel_radius_pixels: f32,
    pub probe_radius_pixels: f32,
    pub max_anisotropy: f32,
    pub minor_radius_texels: f32,
    pub level_blend: f32,
    pub max_fetches: f32,
    pub spatial_threshold: f32,
    pub sampler_anisotropy: u32,
    pub periodic: u32,
    pub frame: u32,
    pub uniform_levels: u32,
    pub seed: u32,
}

impl EwaUniform {
    /// Converts the settings, with `frame` at 0: the temporal methods need it set in each frame.
    pub fn new(settings: &EwaSettings) -> Self {
        let settings = settings.clamped();
        let (method, probes) = match settings.method {
            EwaMethod::Reference => (0, None),
            EwaMethod::Linear => (1, None),
            EwaMethod::Bilinear => (2, None),
            EwaMethod::Approximate { probes } => (3, Some(probes)),
            EwaMethod::Spatial { probes } => (4, Some(probes)),
            EwaMethod::Temporal { probes } => (5, Some(probes)),
            EwaMethod::SpatialTemporal { probes } => (6, Some(probes)),
            EwaMethod::SoftwareAnisotropic => (7, None),
            EwaMethod::Hardware | EwaMethod::Anisotropic => (8, None),
            EwaMethod::Stochastic => (9, None),
        };
        Self {
            method,
            probes: match probes {
                None | Some(EwaProbes::ByAspect) => 0,
                Some(EwaProbes::Three) => 3,
                Some(EwaProbes::Five) => 5,
                Some(EwaProbes::Seven) => 7,
            },
            kernel: match settings.kernel {
                EwaKernel::Box => 0,
                EwaKernel::Tent => 1,
                EwaKernel::Gaussian { .. } => 2,
                EwaKernel::MitchellNetravali => 3,
                EwaKernel::Lanczos => 4,
            },
            level_of_detail: match settings.level_of_detail {
                EwaLevelOfDetail::MinorRadius => 0,
                EwaLevelOfDetail::Hardware => 1,
            },
            kernel_radius_pixels: settings.kernel.radius_pixels(),
            probe_radius_pixels: settings.kernel.probe_radius_pixels(),
            max_anisotropy: settings.max_anisotropy,
            minor_radius_texels: settings.minor_radius_texels,
            level_blend: settings.level_blend,
            max_fetches: settings.max_fetches as f32,
            spatial_threshold: settings.spatial_threshold,
            sampler_anisotropy: settings.sampler_anisotropy.into(),
            periodic: settings.periodic.into(),
            frame: 0,
            uniform_levels: 0,
            seed: 0,
        }
    }
}

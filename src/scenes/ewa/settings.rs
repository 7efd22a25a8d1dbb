//! The settings of the plugin, from those of the scene.

use bevy_ewa::{EwaKernel, EwaLevelOfDetail, EwaMaps, EwaMethod, EwaProbes, EwaSettings};

use crate::runner::{SceneSettings, Side};

/// The methods in the panel.
pub const METHODS: [&str; 11] = [
    "reference",
    "linear",
    "bilinear",
    "approximate",
    "spatial",
    "temporal",
    "spatial_temporal",
    "stochastic",
    "software_af16",
    "anisotropic",
    "hardware",
];
/// Index of Bevy's own.
pub const HARDWARE: usize = 10;
/// Index of the default.
pub const LINEAR: usize = 1;

pub fn ewa_settings(settings: &SceneSettings, side: Side) -> EwaSettings {
    let probes = match settings.choice("probes") {
        "3" => EwaProbes::Three,
        "7" => EwaProbes::Seven,
        "by_aspect" => EwaProbes::ByAspect,
        _ => EwaProbes::Five,
    };
    let method = settings.choice(match side {
        Side::Before => "before",
        Side::After => "after",
    });
    let method = match method {
        "reference" => EwaMethod::Reference,
        "linear" => EwaMethod::Linear,
        "bilinear" => EwaMethod::Bilinear,
        "approximate" => EwaMethod::Approximate { probes },
        "spatial" => EwaMethod::Spatial { probes },
        "temporal" => EwaMethod::Temporal { probes },
        "spatial_temporal" => EwaMethod::SpatialTemporal { probes },
        "stochastic" => EwaMethod::Stochastic,
        "software_af16" => EwaMethod::SoftwareAnisotropic,
        "anisotropic" => EwaMethod::Anisotropic,
        _ => EwaMethod::Hardware,
    };
    let kernel = match settings.choice("kernel") {
        "box" => EwaKernel::Box,
        "tent" => EwaKernel::Tent,
        "mitchell_netravali" => EwaKernel::MitchellNetravali,
        "lanczos" => EwaKernel::Lanczos,
        _ => EwaKernel::Gaussian {
            sigma_pixels: settings.float("sigma"),
        },
    };
    let level_of_detail = match settings.choice("level_of_detail") {
        "hardware" => EwaLevelOfDetail::Hardware,
        _ => EwaLevelOfDetail::MinorRadius,
    };
    EwaSettings {
        method,
        maps: EwaMaps::default(),
        kernel,
        max_anisotropy: settings.float("max_anisotropy"),
        minor_radius_texels: settings.float("minor_radius"),
        level_of_detail,
        level_blend: settings.float("level_blend"),
        max_fetches: settings.integer("max_fetches"),
        spatial_threshold: settings.float("spatial_threshold"),
        sampler_anisotropy: settings.integer("sampler_anisotropy") as u16,
        periodic: true,
    }
}

//! What the knobs make of the settings.

use bevy_ewa::{EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings};

use crate::runner::{Knobs, Side};

/// The methods in the panel.
pub const METHODS: [&str; 9] = [
    "reference",
    "linear",
    "bilinear",
    "approximate",
    "spatial",
    "temporal",
    "spatial_temporal",
    "software_af16",
    "hardware",
];
/// Index of Bevy's own.
pub const HARDWARE: usize = 8;
/// Index of the default.
pub const LINEAR: usize = 1;

/// The settings of a side.
pub fn settings(knobs: &Knobs, side: Side) -> EwaSettings {
    let probes = match knobs.choice("probes") {
        "3" => EwaProbes::Three,
        "7" => EwaProbes::Seven,
        "by_aspect" => EwaProbes::ByAspect,
        _ => EwaProbes::Five,
    };
    let method = knobs.choice(match side {
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
        "software_af16" => EwaMethod::SoftwareAnisotropic,
        _ => EwaMethod::Hardware,
    };
    let kernel = match knobs.choice("kernel") {
        "box" => EwaKernel::Box,
        "tent" => EwaKernel::Tent,
        "mitchell_netravali" => EwaKernel::MitchellNetravali,
        "lanczos" => EwaKernel::Lanczos,
        _ => EwaKernel::Gaussian {
            sigma_pixels: knobs.float("sigma"),
        },
    };
    let level_of_detail = match knobs.choice("level_of_detail") {
        "hardware" => EwaLevelOfDetail::Hardware,
        _ => EwaLevelOfDetail::MinorRadius,
    };
    EwaSettings {
        method,
        kernel,
        max_anisotropy: knobs.float("max_anisotropy"),
        minor_radius_texels: knobs.float("minor_radius"),
        level_of_detail,
        level_blend: knobs.float("level_blend"),
        max_fetches: knobs.integer("max_fetches"),
        spatial_threshold: knobs.float("spatial_threshold"),
        sampler_anisotropy: knobs.integer("sampler_anisotropy") as u16,
        periodic: true,
    }
}

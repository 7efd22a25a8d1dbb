//! What is measured, by name.

use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings};

/// A method with its defaults.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name in the report.
    pub name: &'static str,
    pub method: EwaMethod,
    pub sampler_anisotropy: u16,
    pub frames: u32,
}

/// The settings; the hardware's are left out where there is no hardware.
pub const SETTINGS: [Setting; 11] = [
    setting("reference", EwaMethod::Reference, 1, 1),
    setting("linear", EwaMethod::Linear, 1, 1),
    setting("bilinear", EwaMethod::Bilinear, 1, 1),
    setting("approximate", EwaMethod::Approximate { probes: FIVE }, 1, 1),
    setting("spatial", EwaMethod::Spatial { probes: FIVE }, 1, 1),
    setting("temporal", EwaMethod::Temporal { probes: FIVE }, 1, 2),
    setting(
        "spatial_temporal",
        EwaMethod::SpatialTemporal { probes: FIVE },
        1,
        2,
    ),
    setting("stochastic", EwaMethod::Stochastic, 1, 16),
    setting("software_af16", EwaMethod::SoftwareAnisotropic, 1, 1),
    setting("hardware_af16", EwaMethod::Hardware, 16, 1),
    setting("trilinear", EwaMethod::Hardware, 1, 1),
];

const FIVE: EwaProbes = EwaProbes::Five;

const fn setting(
    name: &'static str,
    method: EwaMethod,
    sampler_anisotropy: u16,
    frames: u32,
) -> Setting {
    Setting {
        name,
        method,
        sampler_anisotropy,
        frames,
    }
}

impl Setting {
    /// The settings of the plugin. Where samplers have anisotropy, probes are the hardware's.
    pub fn settings(&self, probe_anisotropy: u16) -> EwaSettings {
        EwaSettings {
            sampler_anisotropy: self.sampler_anisotropy.max(probe_anisotropy),
            ..EwaSettings::with_method(self.method)
        }
    }

    /// Whether a setting needs a texture unit's own anisotropic filter.
    pub fn needs_hardware(&self) -> bool {
        self.sampler_anisotropy > 1
    }

    pub fn has_probes(&self) -> bool {
        matches!(
            self.method,
            EwaMethod::Approximate { .. }
                | EwaMethod::Spatial { .. }
                | EwaMethod::Temporal { .. }
                | EwaMethod::SpatialTemporal { .. }
        )
    }
}

//! The filtering methods.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

/// A filtering method: those of the thesis and two baselines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum EwaMethod {
    /// Reads every texel of the ellipse, one per fetch (thesis 5.4).
    Reference,
    /// Gives the same picture as `Reference` with two texels per fetch (thesis 5.4.1).
    #[default]
    Linear,
    /// Reads four texels per fetch. Their weights are exact where the axes of the ellipse are parallel to
    /// those of the texture (thesis 5.4.1).
    Bilinear,
    /// Takes anisotropic probes along the major axis (thesis 5.5).
    Approximate {
        /// The number of probes.
        probes: EwaProbes,
    },
    /// Takes one probe along the axes of the ellipse, and uses `Approximate` where the anisotropy
    /// exceeds [`EwaSettings::spatial_threshold`](super::EwaSettings::spatial_threshold) (thesis 5.5.1). It is kept for
    /// comparison: `Approximate` with fewer probes is more accurate at the same cost.
    Spatial {
        /// The number of probes above the threshold.
        probes: EwaProbes,
    },
    /// Splits the probes of `Approximate` over two frames (thesis 5.5.2). It needs a steady frame rate
    /// of 60 Hz or more, or temporal anti-aliasing.
    Temporal {
        /// The number of probes in both frames together.
        probes: EwaProbes,
    },
    /// Takes one probe as `Spatial` does, and uses `Temporal` where the anisotropy exceeds the threshold.
    SpatialTemporal {
        /// The number of probes above the threshold, in both frames together.
        probes: EwaProbes,
    },
    /// Takes one fetch at a random point of the ellipse, chosen with the weights of the kernel, so that the mean of many
    /// frames is the exact filter. It needs temporal anti-aliasing. Kernels with negative lobes are replaced by a
    /// Gaussian that blurs as much.
    Stochastic,
    /// Models the anisotropic filter of a texture unit: trilinear fetches of equal weight along
    /// the longer derivative, at most 16, with the number and the level of detail of the Vulkan
    /// specification (texel anisotropic filtering). It is meant for tests and for drivers without a
    /// usable anisotropic filter.
    SoftwareAnisotropic,
    /// Leaves the lookup to the texture unit and raises the `anisotropy_clamp` of the samplers, to
    /// [`EwaSettings::sampler_anisotropy`](super::EwaSettings::sampler_anisotropy) or else 16. No shader changes: the
    /// pipelines are Bevy's own. In a custom shader it is a lookup by the sampler.
    Anisotropic,
    /// Leaves the lookup to the sampler as it is, which gives the same picture as Bevy without this crate.
    Hardware,
}

impl EwaMethod {
    /// Returns true if the method averages the texels of the ellipse.
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Reference | Self::Linear | Self::Bilinear)
    }
}

/// The number of probes that approximate an ellipse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum EwaProbes {
    /// Three probes.
    Three,
    /// Five probes (thesis 5.5).
    #[default]
    Five,
    /// Seven probes.
    Seven,
    /// As many probes as the anisotropy needs: an odd number from 3 to 15.
    ByAspect,
}

//! Settings of the filter, for one material or for all materials.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

/// The settings by which a texture is filtered.
///
/// Values outside their range are clamped to it; NaN becomes the default.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq))]
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
    #[cfg_attr(feature = "bevy", reflect(@1.0..=1024.0_f32))]
    pub max_anisotropy: f32,
    /// Minimum length of the ellipse's minor radius, in texels of the chosen mip level: T_pp in thesis
    /// equation 5.3. The actual length is less than twice the minimum. Higher values are sharper and
    /// cost more. 0.5 to 4, default 1.5.
    #[cfg_attr(feature = "bevy", reflect(@0.5..=4.0_f32))]
    pub minor_radius_texels: f32,
    /// The formula that chooses the mip level. Default: [`EwaLevelOfDetail::MinorRadius`].
    pub level_of_detail: EwaLevelOfDetail,
    /// Fraction of the interval between two mip levels in which both are read and blended. 0 reads a
    /// single level everywhere, as in the thesis, with a visible step where the level changes; 1 blends
    /// everywhere and costs most. 0 to 1, default 0.25. It affects the exact methods only; probes are
    /// trilinear.
    #[cfg_attr(feature = "bevy", reflect(@0.0..=1.0_f32))]
    pub level_blend: f32,
    /// Upper limit of the texture fetches of one lookup by an exact method. Where the ellipse needs
    /// more, a coarser mip level is read; the ellipse is never cut. 16 to 4096, default 2048.
    #[cfg_attr(feature = "bevy", reflect(@16..=4096_u32))]
    pub max_fetches: u32,
    /// Anisotropy above which [`EwaMethod::Spatial`] replaces its single probe by several, alpha_0 in
    /// thesis 5.5.1. Lower values take several probes, and so more fetches, for more pixels. 2 to 1024,
    /// default 16, where the texture unit reaches its limit.
    #[cfg_attr(feature = "bevy", reflect(@2.0..=1024.0_f32))]
    pub spatial_threshold: f32,
    /// The `anisotropy_clamp` of the samplers of those textures that the texture unit filters. Above 1, the plugin
    /// raises it for the textures of Bevy's materials, and each probe is one fetch by the texture unit; at 1, the
    /// samplers stay as they are, and the shader computes the probes as a texture unit with 16x anisotropy would.
    /// Exact methods apply it to the maps that [`EwaSettings::maps`] leaves out. 1 to 16, default 1, which
    /// [`EwaMethod::Anisotropic`] takes for 16. Samplers that filter otherwise than linearly stay as they are.
    #[cfg_attr(feature = "bevy", reflect(@1..=16_u16))]
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

/// A filtering method: those of the thesis and two baselines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
#[non_exhaustive]
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
    /// exceeds [`EwaSettings::spatial_threshold`] (thesis 5.5.1). It is kept for
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
    /// [`EwaSettings::sampler_anisotropy`] or else 16. No shader changes: the
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
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
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

/// The maps of Bevy's materials that the filter applies to.
///
/// Maps of the same size and UV set share the ellipse and the weights of their texels, so that another one costs its
/// fetches and little more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
pub struct EwaMaps {
    /// The base colour with its alpha, which also cuts the holes of alpha masks. Default: true.
    pub base_color: bool,
    /// The emitted light. Default: true.
    pub emissive: bool,
    /// The normals, also those of the clearcoat. Default: true.
    pub normals: bool,
    /// All other maps: metallic and roughness, occlusion, specular, clearcoat, transmission, anisotropy. Default:
    /// false.
    pub others: bool,
}

impl Default for EwaMaps {
    fn default() -> Self {
        Self {
            base_color: true,
            emissive: true,
            normals: true,
            others: false,
        }
    }
}

impl EwaMaps {
    /// All maps.
    pub const ALL: Self = Self {
        base_color: true,
        emissive: true,
        normals: true,
        others: true,
    };
    /// No map.
    pub const NONE: Self = Self {
        base_color: false,
        emissive: false,
        normals: false,
        others: false,
    };

    /// Returns true if a map of a `StandardMaterial` is one of them, by its name in the fields `*_texture`.
    pub fn contains(self, map: &str) -> bool {
        match map {
            "base_color" => self.base_color,
            "emissive" => self.emissive,
            "normal_map" | "clearcoat_normal" => self.normals,
            _ => self.others,
        }
    }
}

/// A radially symmetric reconstruction filter on the screen (thesis 2.1.5).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq))]
#[non_exhaustive]
pub enum EwaKernel {
    /// A constant weight up to half a pixel from the centre.
    Box,
    /// A weight that falls linearly to zero at one pixel from the centre.
    Tent,
    /// A Gaussian that is cut off at twice its standard deviation and lowered by its value there, so that
    /// it ends at zero.
    Gaussian {
        /// Standard deviation in pixels. Smaller values are sharper and alias more. 0.05 to 2, default
        /// 0.5.
        #[cfg_attr(feature = "bevy", reflect(@0.05..=2.0_f32))]
        sigma_pixels: f32,
    },
    /// The cubic filter of Mitchell and Netravali with B = C = 1/3 and a radius of two pixels.
    MitchellNetravali,
    /// A sinc windowed by a sinc, with a radius of two pixels.
    Lanczos,
}

impl Default for EwaKernel {
    fn default() -> Self {
        Self::Gaussian { sigma_pixels: 0.5 }
    }
}

impl EwaKernel {
    /// Returns the radius of the kernel's support in pixels.
    pub fn radius_pixels(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian { sigma_pixels } => 2.0 * sigma_pixels,
            Self::MitchellNetravali | Self::Lanczos => 2.0,
        }
    }

    /// Returns the radius in pixels of the [`EwaKernel::Gaussian`] that blurs as much: the weights of
    /// probes are always those of a Gaussian. Kernels with negative lobes blur less than any Gaussian;
    /// for them it is the smallest radius that does not alias.
    pub fn probe_radius_pixels(self) -> f32 {
        match self {
            Self::Box => 0.68,
            Self::Tent => 1.05,
            Self::Gaussian { .. } => self.radius_pixels(),
            Self::MitchellNetravali | Self::Lanczos => 0.75,
        }
    }
}

/// The formula that chooses the mip level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
#[non_exhaustive]
pub enum EwaLevelOfDetail {
    /// Follows the minor radius of the ellipse (thesis equation 5.3).
    #[default]
    MinorRadius,
    /// Divides the longer derivative by the number of its anisotropic taps, as texture units do, and
    /// ignores the angle between the derivatives. WGSL has no query for the texture unit's own level.
    Hardware,
}

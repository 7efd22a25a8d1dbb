//! What a user chooses, per material or for all of them.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

/// How a texture is filtered, with all that can be tuned.
///
/// Values outside their ranges are brought into them; what is not a number counts as the default.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub struct EwaSettings {
    /// From reference quality to nearly the speed of the texture unit. Default:
    /// [`EwaMethod::Linear`].
    pub method: EwaMethod,
    /// The reconstruction filter of a pixel on the screen. Default: a Gaussian with a standard
    /// deviation of half a pixel (thesis 5.6).
    pub kernel: EwaKernel,
    /// Largest ratio of the axes of the ellipse; rounder ones are as they are, longer ones get a
    /// wider minor axis. 1 to 1024, default 32 (thesis table 5.1).
    pub max_anisotropy: f32,
    /// Texels that the minor radius of the ellipse has at least in the chosen mip level, T_pp in
    /// thesis equation 5.3: more are sharper and cost more. It has less than twice as many. 0.5 to
    /// 4, default 1.5.
    pub minor_radius_texels: f32,
    /// What the mip level is chosen by. Default: [`EwaLevelOfDetail::MinorRadius`].
    pub level_of_detail: EwaLevelOfDetail,
    /// Part of the way from a mip level to the next in which both are blended: 0 is one level
    /// throughout, as in the thesis, with a step where it changes; 1 blends everywhere. Default
    /// 0.25. For the exact methods; probes are trilinear.
    pub level_blend: f32,
    /// Most texture fetches that one lookup of an exact method may take. Where the ellipse needs
    /// more, a coarser mip level is read; the ellipse is never cut. 16 to 4096, default 2048.
    pub max_fetches: u32,
    /// Anisotropy above which [`EwaMethod::Spatial`] works, alpha_0 in thesis 5.5.1. 2 to 1024,
    /// default 16, where the texture unit reaches its limit.
    pub spatial_threshold: f32,
    /// Anisotropy that the samplers of the textures have: Bevy's
    /// `ImageSamplerDescriptor::anisotropy_clamp`. From 2 on, probes are left to the texture unit;
    /// at 1 they are computed, as a texture unit with 16 would. 1 to 16, default 1, as in Bevy.
    pub sampler_anisotropy: u16,
    /// Whether the textures repeat or mirror, so that texture coordinates beyond 16 can be reduced
    /// by whole periods and stay precise. Bevy's materials are asked themselves: it is off for those
    /// with a texture whose sampler clamps. In shaders of one's own, switch it off for textures that
    /// are clamped and seen with coordinates as large as that. Default true.
    pub periodic: bool,
}

impl Default for EwaSettings {
    fn default() -> Self {
        Self {
            method: EwaMethod::default(),
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
    /// The default settings with another method.
    pub fn with_method(method: EwaMethod) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }

    /// The same with every value in its range.
    pub fn sanitized(self) -> Self {
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

/// The methods of the thesis, and what they are compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum EwaMethod {
    /// Every texel of the ellipse, one a fetch (thesis 5.4).
    Reference,
    /// The same picture with two texels a fetch (thesis 5.4.1).
    #[default]
    Linear,
    /// Four texels a fetch, whose weights are exact where the ellipse lies along the texture's axes
    /// (thesis 5.4.1).
    Bilinear,
    /// Anisotropic probes along the major axis (thesis 5.5).
    Approximate {
        /// How many.
        probes: EwaProbes,
    },
    /// One probe along the axes of the ellipse, and `Approximate` where the anisotropy exceeds
    /// [`EwaSettings::spatial_threshold`] (thesis 5.5.1).
    Spatial {
        /// How many there.
        probes: EwaProbes,
    },
    /// `Approximate` with its probes split over two frames (thesis 5.5.2). For steady frame rates
    /// of 60 Hz or more, or with temporal anti-aliasing.
    Temporal {
        /// How many in both frames together.
        probes: EwaProbes,
    },
    /// `Spatial`, with `Temporal` where the anisotropy exceeds the threshold.
    SpatialTemporal {
        /// How many there, in both frames together.
        probes: EwaProbes,
    },
    /// A model of the anisotropic filter of a texture unit: trilinear fetches of equal weight along
    /// the longer derivative, at most 16, with the number and the level of detail of the Vulkan
    /// specification (texel anisotropic filtering). For machines and tests whose driver has none
    /// worth the name.
    SoftwareAnisotropic,
    /// What the sampler does: Bevy's own picture.
    Hardware,
}

/// How many probes approximate an ellipse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum EwaProbes {
    /// Three.
    Three,
    /// Five (thesis 5.5).
    #[default]
    Five,
    /// Seven.
    Seven,
    /// As many as the anisotropy needs, odd, 3 to 15.
    ByAspect,
}

/// A reconstruction filter on the screen, round (thesis 2.1.5).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
pub enum EwaKernel {
    /// Constant within half a pixel.
    Box,
    /// Falls linearly to zero at one pixel.
    Tent,
    /// A Gaussian that ends at twice its standard deviation, less its value there, so that it ends
    /// in zero.
    Gaussian {
        /// Standard deviation in pixels: smaller is sharper and aliases more. 0.05 to 2, default
        /// 0.5.
        sigma_pixels: f32,
    },
    /// The cubic of Mitchell and Netravali with B = C = 1/3, two pixels in radius.
    MitchellNetravali,
    /// A sinc windowed by a sinc, two pixels in radius.
    Lanczos,
}

impl Default for EwaKernel {
    fn default() -> Self {
        Self::Gaussian { sigma_pixels: 0.5 }
    }
}

impl EwaKernel {
    /// Where the kernel ends, in pixels from the centre of its pixel.
    pub fn radius_pixels(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian { sigma_pixels } => 2.0 * sigma_pixels,
            Self::MitchellNetravali | Self::Lanczos => 2.0,
        }
    }

    /// The radius in pixels of a Gaussian of this module that blurs as much: probes have no weights
    /// but that one's. Kernels with negative lobes blur less than any; theirs is the smallest that
    /// does not alias.
    pub fn probe_radius_pixels(self) -> f32 {
        match self {
            Self::Box => 0.68,
            Self::Tent => 1.05,
            Self::Gaussian { .. } => self.radius_pixels(),
            Self::MitchellNetravali | Self::Lanczos => 0.75,
        }
    }
}

/// What the mip level is chosen by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum EwaLevelOfDetail {
    /// The minor radius of the ellipse (thesis equation 5.3).
    #[default]
    MinorRadius,
    /// The formula of texture units: the longer derivative over the number of its anisotropic taps,
    /// blind to the angle between the derivatives. WGSL cannot ask the texture unit itself.
    Hardware,
}

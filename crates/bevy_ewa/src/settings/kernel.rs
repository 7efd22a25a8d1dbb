//! The reconstruction filters, and the formulas of the mip level.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

/// A radially symmetric reconstruction filter on the screen (thesis 2.1.5).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
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
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum EwaLevelOfDetail {
    /// Follows the minor radius of the ellipse (thesis equation 5.3).
    #[default]
    MinorRadius,
    /// Divides the longer derivative by the number of its anisotropic taps, as texture units do, and
    /// ignores the angle between the derivatives. WGSL has no query for the texture unit's own level.
    Hardware,
}

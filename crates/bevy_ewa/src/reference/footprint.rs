//! The ellipse of a pixel in a texture, its mip level and its fetch budget.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::settings::{EwaLevelOfDetail, EwaSettings};

/// The amount by which a ratio may exceed an integer before it is rounded up: the tolerance for the
/// rounding errors of 32-bit floats.
pub const CEIL_TOLERANCE: f64 = 1e-3;

/// Screen-space derivatives of the texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// Change of (u, v) by one pixel to the right.
    pub dx: [f64; 2],
    /// Change of (u, v) by one pixel down.
    pub dy: [f64; 2],
}

/// The ellipse in a texture that a disc with a radius of one pixel projects to, in texels of the finest
/// level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Length of the major radius.
    pub major_radius_texels: f64,
    /// Length of the minor radius, after the anisotropy is limited.
    pub minor_radius_texels: f64,
    /// Direction of the major axis, of length 1.
    pub major_direction: [f64; 2],
    /// Ratio of the radii before it is limited; infinite for a line, 1 for a point.
    pub anisotropy: f64,
    /// Level of detail by the formula of texture units: log2 of the longer derivative in texels divided
    /// by the number of its taps.
    pub hardware_lod: f64,
}

/// Radius in texels beyond which a footprint counts as the whole texture.
pub(super) const MAX_RADIUS_TEXELS: f64 = 1e12;

impl Footprint {
    /// Computes the footprint in a texture of this size.
    ///
    /// Derivatives that are not finite give a disc of a huge radius, which covers the whole texture.
    pub fn new(derivatives: Derivatives, size: [u32; 2], max_anisotropy: f64) -> Self {
        let texels = |d: [f64; 2]| [d[0] * f64::from(size[0]), d[1] * f64::from(size[1])];
        let (a, b) = (texels(derivatives.dx), texels(derivatives.dy));
        let scale = a.iter().chain(&b).fold(0.0, |largest: f64, c| {
            // `max` would ignore NaN.
            if c.is_nan() {
                f64::INFINITY
            } else {
                largest.max(c.abs())
            }
        });
        if scale > MAX_RADIUS_TEXELS {
            return Self::disc(MAX_RADIUS_TEXELS);
        }
        if scale < 1.0 / MAX_RADIUS_TEXELS {
            return Self::disc(0.0);
        }
        // Scaled to order 1, so that no square overflows or underflows.
        let (a, b) = (a.map(|c| c / scale), b.map(|c| c / scale));
        let xx = a[0] * a[0] + b[0] * b[0];
        let yy = a[1] * a[1] + b[1] * b[1];
        let xy = a[0] * a[1] + b[0] * b[1];
        // The larger eigenvalue is computed from the trace and the smaller one from the determinant: the
        // difference in equation 5.3 suffers cancellation.
        let root = ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt();
        let major_squared = (xx + yy + root) / 2.0;
        let determinant = a[0] * b[1] - a[1] * b[0];
        let major = major_squared.sqrt();
        let minor = determinant.abs() / major;
        let direction = if xx >= yy {
            [major_squared - yy, xy]
        } else {
            [xy, major_squared - xx]
        };
        let length = direction[0].hypot(direction[1]);
        let direction = if length > 1e-12 {
            direction.map(|c| c / length)
        } else {
            [1.0, 0.0]
        };
        let long = a[0].hypot(a[1]).max(b[0].hypot(b[1]));
        let short = a[0].hypot(a[1]).min(b[0].hypot(b[1]));
        let taps = (long / short.max(long / 16.0) - CEIL_TOLERANCE).ceil();
        Self {
            major_radius_texels: major * scale,
            minor_radius_texels: minor.max(major / max_anisotropy) * scale,
            major_direction: direction,
            anisotropy: major / minor,
            hardware_lod: (long / taps * scale).log2(),
        }
    }

    fn disc(radius: f64) -> Self {
        Self {
            major_radius_texels: radius,
            minor_radius_texels: radius,
            major_direction: [1.0, 0.0],
            anisotropy: 1.0,
            hardware_lod: radius.max(1.0 / MAX_RADIUS_TEXELS).log2(),
        }
    }

    /// Returns the level of detail at which the exact methods read, not yet clamped to the existing
    /// levels. At its floor the minor radius has a length of `minor_radius_texels` to twice as much, or
    /// less if the budget requires it.
    pub fn lod(&self, settings: &EwaSettings) -> f64 {
        let radius = f64::from(settings.kernel.radius_pixels());
        let texels = f64::from(settings.minor_radius_texels);
        let size_lod = match settings.level_of_detail {
            EwaLevelOfDetail::MinorRadius => {
                self.minor_radius_texels.max(1.0 / MAX_RADIUS_TEXELS).log2()
            }
            EwaLevelOfDetail::Hardware => self.hardware_lod,
        };
        (size_lod + (radius / texels).log2()).max(self.budget_lod(settings))
    }

    /// The finest level of detail that keeps within the budget: [`max_texels`] solved for the scale, at
    /// the floor of the level of detail, where lengths in texels are at most doubled.
    fn budget_lod(&self, settings: &EwaSettings) -> f64 {
        let radius = f64::from(settings.kernel.radius_pixels());
        let (a, b) = (
            radius * self.major_radius_texels,
            radius * self.minor_radius_texels,
        );
        let levels = if settings.level_blend > 0.0 { 2.0 } else { 1.0 };
        // At one fetch per texel, the texels that the ellipse of one level may have.
        let texels = f64::from(settings.max_fetches) / levels;
        // PI (a s + 1) (b s + 1) + 4 / sqrt(2) ((a s + 1) + (b s + 1)) + PI / 2 = texels
        let slope = 4.0 * FRAC_1_SQRT_2;
        let square = PI * a * b;
        let linear = (PI + slope) * (a + b);
        let constant = PI + 2.0 * slope + PI / 2.0 - texels;
        if constant >= 0.0 {
            return MAX_RADIUS_TEXELS.log2();
        }
        // This form of the root has no cancellation; it also holds where the quadratic term is 0.
        let root = (linear * linear - 4.0 * square * constant).sqrt();
        let scale = -2.0 * constant / (linear + root).max(1.0 / MAX_RADIUS_TEXELS);
        1.0 - scale.log2()
    }
}

/// Returns an upper bound of the number of texel centres inside an ellipse with these radii: the unit
/// squares around them lie in the ellipse enlarged by half a diagonal, and the ellipse's perimeter is
/// below `4 (major + minor)`.
pub fn max_texels(major_radius: f64, minor_radius: f64) -> f64 {
    let sum = major_radius + minor_radius;
    PI * major_radius * minor_radius + 4.0 * FRAC_1_SQRT_2 * sum + PI / 2.0
}

//! The ellipse of a pixel in a texture, its mip level, its budget.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::probes::TIE;
use crate::settings::{EwaLevelOfDetail, EwaSettings};

/// How texture coordinates change from a pixel to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// By a pixel to the right.
    pub dx: [f64; 2],
    /// By a pixel down.
    pub dy: [f64; 2],
}

/// What a pixel of one pixel in radius covers of a texture, in texels of the finest level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Longer radius.
    pub major_radius_texels: f64,
    /// Shorter radius, after the anisotropy is limited.
    pub minor_radius_texels: f64,
    /// Direction of the longer one, of length 1.
    pub major_direction: [f64; 2],
    /// Ratio of the radii before it is limited; infinite for a line, 1 for a point.
    pub anisotropy: f64,
    /// log2 of the minor radius by the formula of texture units.
    pub hardware_lod: f64,
}

/// Texels beyond which a radius is no more than "everything".
pub(super) const HUGE: f64 = 1e12;

impl Footprint {
    /// The footprint in a texture of this size.
    ///
    /// Derivatives that are not numbers or not finite mean that the pixel sees everything: a disc
    /// of a huge radius.
    pub fn new(derivatives: Derivatives, size: [u32; 2], max_anisotropy: f64) -> Self {
        let texels = |d: [f64; 2]| [d[0] * f64::from(size[0]), d[1] * f64::from(size[1])];
        let (a, b) = (texels(derivatives.dx), texels(derivatives.dy));
        let scale = a.iter().chain(&b).fold(0.0, |largest: f64, c| {
            // `max` would drop what is not a number.
            if c.is_nan() {
                f64::INFINITY
            } else {
                largest.max(c.abs())
            }
        });
        if scale > HUGE {
            return Self::disc(HUGE);
        }
        if scale < 1.0 / HUGE {
            return Self::disc(0.0);
        }
        // Of order 1, so that no square overflows or vanishes.
        let (a, b) = (a.map(|c| c / scale), b.map(|c| c / scale));
        let xx = a[0] * a[0] + b[0] * b[0];
        let yy = a[1] * a[1] + b[1] * b[1];
        let xy = a[0] * a[1] + b[0] * b[1];
        // One eigenvalue from the trace and the other from the determinant: the difference that
        // equation 5.3 takes cancels out.
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
        let taps = (long / short.max(long / 16.0) - TIE).ceil();
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
            hardware_lod: radius.max(1.0 / HUGE).log2(),
        }
    }

    /// The level of detail at which the exact methods read, not yet limited to the levels there
    /// are: at its floor the minor radius has `minor_radius_texels` to twice as many, or fewer if
    /// the budget demands it.
    pub fn lod(&self, settings: &EwaSettings) -> f64 {
        let radius = f64::from(settings.kernel.radius_pixels());
        let texels = f64::from(settings.minor_radius_texels);
        let by_size = match settings.level_of_detail {
            EwaLevelOfDetail::MinorRadius => self.minor_radius_texels.max(1.0 / HUGE).log2(),
            EwaLevelOfDetail::Hardware => self.hardware_lod,
        };
        (by_size + (radius / texels).log2()).max(self.lod_of_budget(settings))
    }

    /// The finest level of detail that keeps within the budget: [`most_texels`] at its floor, where
    /// texels are at most twice as many to a length, solved for the scale.
    fn lod_of_budget(&self, settings: &EwaSettings) -> f64 {
        let radius = f64::from(settings.kernel.radius_pixels());
        let (a, b) = (
            radius * self.major_radius_texels,
            radius * self.minor_radius_texels,
        );
        let texels = texels_of_budget(settings);
        // PI (a s + 1) (b s + 1) + 4 / sqrt(2) ((a s + 1) + (b s + 1)) + PI / 2 = texels
        let slope = 4.0 * FRAC_1_SQRT_2;
        let square = PI * a * b;
        let linear = (PI + slope) * (a + b);
        let constant = PI + 2.0 * slope + PI / 2.0 - texels;
        if constant >= 0.0 {
            return HUGE.log2();
        }
        // The form that does not cancel; it also holds where the square vanishes.
        let root = (linear * linear - 4.0 * square * constant).sqrt();
        let scale = -2.0 * constant / (linear + root).max(1.0 / HUGE);
        1.0 - scale.log2()
    }
}

/// Texels that one level may have in its ellipse for the budget to hold, were each a fetch.
fn texels_of_budget(settings: &EwaSettings) -> f64 {
    let fetches = f64::from(settings.max_fetches);
    let levels = if settings.level_blend > 0.0 { 2.0 } else { 1.0 };
    fetches / levels
}

/// At least as many as an ellipse with these radii can have texel centres inside: the unit squares
/// around them lie in the ellipse grown by half a diagonal, whose perimeter is below
/// `4 (major + minor)`.
pub fn most_texels(major_radius: f64, minor_radius: f64) -> f64 {
    let sum = major_radius + minor_radius;
    PI * major_radius * minor_radius + 4.0 * FRAC_1_SQRT_2 * sum + PI / 2.0
}

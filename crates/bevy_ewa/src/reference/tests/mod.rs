//! Properties that hold for every texture, footprint and method.

mod filters;
mod footprints;

use super::{scenes::Surface, texture::Color, *};
use crate::settings::*;

pub(super) const EXACT: [EwaMethod; 3] =
    [EwaMethod::Reference, EwaMethod::Linear, EwaMethod::Bilinear];

const FIVE: EwaProbes = EwaProbes::Five;

pub(super) const METHODS: [EwaMethod; 9] = [
    EwaMethod::Reference,
    EwaMethod::Linear,
    EwaMethod::Bilinear,
    EwaMethod::Approximate { probes: FIVE },
    EwaMethod::Spatial { probes: FIVE },
    EwaMethod::Temporal { probes: FIVE },
    EwaMethod::SpatialTemporal { probes: FIVE },
    EwaMethod::SoftwareAnisotropic,
    EwaMethod::Hardware,
];

pub(crate) const KERNELS: [EwaKernel; 5] = [
    EwaKernel::Box,
    EwaKernel::Tent,
    EwaKernel::Gaussian { sigma_pixels: 0.5 },
    EwaKernel::MitchellNetravali,
    EwaKernel::Lanczos,
];

/// A texture of noise that is the same in every run.
pub(super) fn noise(size: [u32; 2]) -> Texture {
    Texture::from_fn(size, |x, y| {
        let mut hash = u64::from(x) << 32 | u64::from(y);
        [0, 1, 2, 3].map(|_| {
            hash = (hash ^ hash >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            hash = hash.wrapping_add(0x9e37_79b9_7f4a_7c15);
            (hash >> 40) as f64 / f64::from(1 << 24)
        })
    })
}

/// A checkerboard in linear light.
pub(crate) fn checks(dark: f64) -> Texture {
    Texture::from_fn([256, 256], |x, y| {
        let is_bright = (x / 32 + y / 32) % 2 == 0;
        let v = if is_bright { 0.9 } else { dark };
        [v, v, v, 1.0]
    })
}

/// A plane at this angle, whose texture is rotated, in degrees.
pub(crate) fn plane(grazing: f64, half_fov: f64, rotation: f64, scale: f64) -> Surface {
    Surface::Plane {
        grazing_angle: grazing.to_radians(),
        tan_half_fov: half_fov.to_radians().tan(),
        rotation: rotation.to_radians(),
        scale,
        camera_position: 0.0,
    }
}

pub(crate) const TUNNEL: Surface = Surface::Tunnel {
    tan_half_fov: 1.0,
    around: 4.0,
    along: 0.5,
    camera_position: 0.0,
};

/// Returns derivatives whose footprint has these radii in texture coordinates, with the major axis at an
/// angle to u.
pub(crate) fn ellipse(major: f64, minor: f64, angle: f64) -> Derivatives {
    let (sin, cos) = angle.sin_cos();
    Derivatives {
        dx: [major * cos, major * sin],
        dy: [-minor * sin, minor * cos],
    }
}

/// Returns the derivatives of the same ellipse in a picture that is rotated.
pub(crate) fn rotated(Derivatives { dx, dy }: Derivatives, angle: f64) -> Derivatives {
    let (sin, cos) = angle.sin_cos();
    let mixed = |a: f64, b: f64| [0, 1].map(|i| a * dx[i] + b * dy[i]);
    Derivatives {
        dx: mixed(cos, sin),
        dy: mixed(-sin, cos),
    }
}

/// Filters by the default settings of a method.
pub(super) fn sample_by(
    method: EwaMethod,
    texture: &Texture,
    uv: [f64; 2],
    derivatives: Derivatives,
) -> Sampled {
    let settings = EwaSettings::with_method(method);
    sample(texture, uv, derivatives, &settings, 0)
}

/// Returns the largest absolute difference over the channels.
pub(super) fn difference(a: Color, b: Color) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

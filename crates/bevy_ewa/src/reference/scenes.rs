//! Test scenes as functions of a point on the screen, so that their ground truth, by supersampling, needs no renderer.

use std::f64::consts::TAU;

use super::{
    exact::weight,
    footprint::Derivatives,
    texture::{Color, Texture, add_weighted},
};
use crate::settings::EwaKernel;

/// A surface that fills the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The inside of an infinite cylinder of radius 1, viewed along its axis (thesis figure 5.10).
    Tunnel {
        /// Tangent of half the field of view.
        tan_half_fov: f64,
        /// Number of texture repetitions around the axis.
        around: f64,
        /// Texture repetitions per unit of length.
        along: f64,
        /// Position of the camera along the axis, in texture repetitions.
        camera_position: f64,
    },
    /// A plane one unit below the camera.
    Plane {
        /// Angle between the view direction and the plane, in radians.
        grazing_angle: f64,
        /// Tangent of half the field of view; the horizon must stay above the picture.
        tan_half_fov: f64,
        /// Rotation of the texture, in radians.
        rotation: f64,
        /// Texture repetitions per unit of length.
        scale: f64,
        /// Position of the camera along v, in texture repetitions.
        camera_position: f64,
    },
}

impl Surface {
    /// Returns the texture coordinates at a position on the screen, from -1 to 1 to the right and down.
    pub fn uv(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::Tunnel {
                tan_half_fov,
                around,
                along,
                camera_position,
            } => {
                let distance = 1.0 / (x.hypot(y) * tan_half_fov).max(1e-9);
                [
                    around * y.atan2(x) / TAU,
                    along * distance + camera_position,
                ]
            }
            Self::Plane {
                grazing_angle,
                tan_half_fov,
                rotation,
                scale,
                camera_position,
            } => {
                let (sin, cos) = grazing_angle.sin_cos();
                let down = (sin + y * tan_half_fov * cos).max(1e-9);
                let forward = cos - y * tan_half_fov * sin;
                let p = [x * tan_half_fov / down, forward / down];
                let (sin, cos) = rotation.sin_cos();
                [
                    scale * (cos * p[0] - sin * p[1]),
                    scale * (sin * p[0] + cos * p[1]) + camera_position,
                ]
            }
        }
    }

    /// Returns the surface after the camera moved by this number of texture repetitions.
    pub fn with_camera_moved_by(mut self, textures: f64) -> Self {
        let (Self::Tunnel {
            camera_position, ..
        }
        | Self::Plane {
            camera_position, ..
        }) = &mut self;
        *camera_position += textures;
        self
    }

    /// Returns the texture coordinates at the centre of a pixel of a square picture, and their
    /// derivatives.
    pub fn pixel(&self, size: u32, [x, y]: [u32; 2]) -> ([f64; 2], Derivatives) {
        const STEP: f64 = 1e-3;
        let at = |dx: f64, dy: f64| self.at(size, [x as f64 + 0.5 + dx, y as f64 + 0.5 + dy]);
        let difference = |a: [f64; 2], b: [f64; 2]| {
            let mut d = [0, 1].map(|i| b[i] - a[i]);
            if let Self::Tunnel { around, .. } = self {
                // u wraps around at the seam.
                d[0] -= around * (d[0] / around).round();
            }
            d.map(|d| d / (2.0 * STEP))
        };
        let derivatives = Derivatives {
            dx: difference(at(-STEP, 0.0), at(STEP, 0.0)),
            dy: difference(at(0.0, -STEP), at(0.0, STEP)),
        };
        (at(0.0, 0.0), derivatives)
    }

    /// Returns the texture coordinates at a position in pixels of a square picture.
    pub fn at(&self, size: u32, position: [f64; 2]) -> [f64; 2] {
        self.uv(position.map(|p| 2.0 * p / f64::from(size) - 1.0))
    }
}

/// Computes the colour of a pixel from `rate` times `rate` samples per pixel of the texture's finest
/// level, with bilinear reconstruction and a kernel on the screen.
pub fn ground_truth(
    texture: &Texture,
    surface: &Surface,
    size: u32,
    pixel: [u32; 2],
    kernel: EwaKernel,
    rate: u32,
) -> Color {
    let radius = f64::from(kernel.radius_pixels());
    let half = (radius * f64::from(rate)).ceil() as i64;
    let texels = texture.size().map(f64::from);
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for j in -half..half {
        for i in -half..half {
            let offset = jittered(i, j).map(|p| p / f64::from(rate));
            let distance = offset[0].hypot(offset[1]) / radius;
            let w = weight(kernel, distance * distance);
            if w == 0.0 {
                continue;
            }
            let at = [0, 1].map(|k| f64::from(pixel[k]) + 0.5 + offset[k]);
            let uv = surface.at(size, at);
            sum = add_weighted(
                sum,
                texture.bilinear(0, [0, 1].map(|k| uv[k] * texels[k])),
                w,
            );
            total += w;
        }
    }
    sum.map(|c| c / total)
}

/// Returns a random point of a cell: regular samples would alias with checkerboards.
fn jittered(i: i64, j: i64) -> [f64; 2] {
    let mut hash = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (j as u64).rotate_left(32);
    let mut random = || {
        hash ^= hash >> 30;
        hash = hash.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash ^= hash >> 27;
        hash = hash.wrapping_mul(0x94d0_49bb_1331_11eb);
        hash ^= hash >> 31;
        (hash >> 11) as f64 / (1u64 << 53) as f64
    };
    [i as f64 + random(), j as f64 + random()]
}

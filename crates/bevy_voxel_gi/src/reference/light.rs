//! Direct light on surfaces, shadowed by the voxels (thesis 6.5.4).

use super::{ray_sample::hit_radiance, surface::Surface, trace::trace, voxels::Voxels};
use glam::Vec3;

/// A light source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Parallel light from infinitely far away.
    Directional {
        /// Direction in which the light travels, a unit vector.
        direction: Vec3,
        /// Irradiance of a surface that faces the light, in lux per channel.
        illuminance: Vec3,
    },
    /// Light from a point, in all directions or in a cone.
    Point {
        /// Position in metres.
        position: Vec3,
        /// Luminous intensity per channel, in candela (lumens / 4 pi).
        intensity: Vec3,
        /// The cone of a spot light; `None` for a point light.
        cone: Option<Cone>,
    },
}

/// The cone of a spot light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Axis of the cone, the direction in which the light travels, a unit vector.
    pub direction: Vec3,
    /// Angle from the axis up to which it has full intensity, in radians.
    pub inner: f32,
    /// Angle from the axis at which it ends, in radians, at most pi / 2.
    pub outer: f32,
}

impl Cone {
    /// Returns the attenuation at a cosine from the axis, as in Bevy.
    pub fn attenuation(&self, cosine: f32) -> f32 {
        let range = (self.inner.cos() - self.outer.cos()).max(1e-4);
        let t = ((cosine - self.outer.cos()) / range).clamp(0.0, 1.0);
        t * t
    }
}

impl Light {
    /// Direction to the light, distance to it in metres, and irradiance of a surface that faces it.
    ///
    /// The distance is clamped to at least `nearest`, in metres, for the irradiance.
    fn at(&self, position: Vec3, nearest: f32) -> (Vec3, f32, Vec3) {
        match *self {
            Self::Directional {
                direction,
                illuminance,
            } => (-direction, f32::INFINITY, illuminance),
            Self::Point {
                position: source,
                intensity,
                cone,
            } => {
                let to = source - position;
                let distance = to.length();
                let direction = to / distance.max(1e-9);
                let attenuation = cone.map_or(1.0, |c| c.attenuation(-direction.dot(c.direction)));
                let squared = distance.max(nearest).powi(2);
                (direction, distance, intensity * attenuation / squared)
            }
        }
    }
}

/// Returns the direct irradiance of a surface in lux, the mean over up to `samples` of its points.
pub fn direct_light(voxels: &Voxels, surface: &Surface, lights: &[Light], samples: u32) -> Vec3 {
    let size = voxels.grid.voxel_size;
    let count = surface.points.len().min(samples as usize);
    let mut total = Vec3::ZERO;
    for light in lights {
        let mut sum = Vec3::ZERO;
        let mut valid = count;
        for k in 0..count {
            let point = (2 * k + 1) * surface.points.len() / (2 * count);
            let world = voxels.grid.to_world(surface.points[point]);
            let (direction, distance, irradiance) = light.at(world, 0.125 * size);
            let cosine = surface.normal.dot(direction);
            if cosine <= 0.0 {
                continue;
            }
            let origin = surface.origin(point);
            let reach = distance / size - surface.ray_offset;
            match trace(voxels, origin, direction, reach) {
                None => sum += irradiance * cosine,
                Some(hit) => {
                    // The point may be inside geometry.
                    let sample = hit_radiance(voxels, &hit, direction, |_, _| Vec3::ZERO);
                    valid -= usize::from(sample.is_inside_geometry());
                }
            }
        }
        total += sum / valid.max(1) as f32;
    }
    total
}

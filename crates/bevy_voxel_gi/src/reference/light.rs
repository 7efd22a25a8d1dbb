//! Direct light on surfaces, shadowed by the voxels (thesis 6.5.4).

use super::{
    surface::Surface,
    trace::{hit_radiance, trace},
    voxels::Voxels,
};
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
        /// What is nearer to the light casts no shadow, in metres.
        near: f32,
    },
    /// Light from one side of a rectangle.
    Rectangle(Rectangle),
}

/// A rectangle that emits light from one side, with the same radiance in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Its centre in metres.
    pub center: Vec3,
    /// From the centre to the middle of an edge, in metres.
    pub half_width: Vec3,
    /// The same of an edge beside it.
    pub half_height: Vec3,
    /// The normal of the side that emits, a unit vector.
    pub direction: Vec3,
    /// Radiance per channel, in cd/m².
    pub radiance: Vec3,
}

impl Rectangle {
    /// Cells along an edge: light comes from points in the middle of cells.
    const CELLS: usize = 4;

    /// For each cell, the way to its middle, and the share of its radiance and area that arrives at a surface.
    ///
    /// Distances are clamped to at least `nearest`, in metres.
    fn cells(
        &self,
        position: Vec3,
        normal: Vec3,
        nearest: f32,
    ) -> impl Iterator<Item = (Vec3, f32)> {
        let middle = |i: usize| (2 * i + 1) as f32 / Self::CELLS as f32 - 1.0;
        (0..Self::CELLS * Self::CELLS).map(move |cell| {
            let to = self.center
                + middle(cell % Self::CELLS) * self.half_width
                + middle(cell / Self::CELLS) * self.half_height
                - position;
            let squared = to.length_squared().max(nearest * nearest);
            let cosines = to.dot(normal).max(0.0) * (-to).dot(self.direction).max(0.0);
            (to, cosines / (squared * squared))
        })
    }

    /// Returns the irradiance of a surface, if nothing is between it and the rectangle.
    pub fn irradiance(&self, position: Vec3, normal: Vec3, nearest: f32) -> Vec3 {
        let area = 4.0 * self.half_width.cross(self.half_height).length();
        let shares: f32 = self
            .cells(position, normal, nearest)
            .map(|cell| cell.1)
            .sum();
        self.radiance * area / (Self::CELLS * Self::CELLS) as f32 * shares
    }

    /// Returns the way to the cell that a point of the surface looks at for its shadow: one of its own, or if that
    /// does not light it, the one that lights it most.
    fn seen(&self, number: usize, position: Vec3, normal: Vec3, nearest: f32) -> Vec3 {
        let cells: Vec<_> = self.cells(position, normal, nearest).collect();
        let own = cells[7 * number % cells.len()];
        let best = cells.into_iter().rev().max_by(|a, b| a.1.total_cmp(&b.1));
        if own.1 > 0.0 {
            own.0
        } else {
            best.unwrap_or(own).0
        }
    }
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
    /// Direction to the light at the `number`-th point of a surface, the distance in metres on which nothing may
    /// be, and the irradiance.
    ///
    /// The distance is clamped to at least `nearest`, in metres, for the irradiance.
    fn at(&self, number: usize, position: Vec3, normal: Vec3, nearest: f32) -> (Vec3, f32, Vec3) {
        match *self {
            Self::Directional {
                direction,
                illuminance,
            } => {
                let cosine = normal.dot(-direction).max(0.0);
                (-direction, f32::INFINITY, illuminance * cosine)
            }
            Self::Rectangle(rectangle) => {
                let to = rectangle.seen(number, position, normal, nearest);
                let irradiance = rectangle.irradiance(position, normal, nearest);
                (to.normalize_or_zero(), to.length(), irradiance)
            }
            Self::Point {
                position: source,
                intensity,
                cone,
                near,
            } => {
                let to = source - position;
                let distance = to.length();
                let direction = to / distance.max(1e-9);
                let attenuation = cone.map_or(1.0, |c| c.attenuation(-direction.dot(c.direction)));
                let squared = distance.max(nearest).powi(2);
                let cosine = normal.dot(direction).max(0.0);
                let irradiance = intensity * attenuation / squared * cosine;
                (direction, distance - near, irradiance)
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
            let normal = surface.normal;
            let (direction, distance, irradiance) = light.at(k, world, normal, 0.125 * size);
            if irradiance.max_element() <= 0.0 {
                continue;
            }
            let (origin, way) = surface.start_towards(voxels, point, direction);
            let reach = distance / size - way;
            match trace(voxels, origin, direction, reach) {
                None => sum += irradiance,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The irradiance of a surface that faces a corner of a rectangle at a distance: the analytic view factor of
    /// a differential area and a parallel rectangle with a corner above it.
    fn below_corner(width: f64, height: f64, distance: f64) -> f64 {
        let (x, y) = (width / distance, height / distance);
        let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        0.5 * (x / sx * (y / sx).atan() + y / sy * (x / sy).atan())
    }

    #[test]
    fn a_rectangle_is_as_bright_as_its_view_factor() {
        for distance in [0.4_f32, 0.5, 1.0, 3.0, 20.0] {
            let rectangle = Rectangle {
                center: Vec3::new(0.0, distance, 0.0),
                half_width: Vec3::X,
                half_height: Vec3::Z * 0.5,
                direction: Vec3::NEG_Y,
                radiance: Vec3::ONE,
            };
            let found = rectangle.irradiance(Vec3::ZERO, Vec3::Y, 0.0).x;
            let expected = 4.0 * below_corner(1.0, 0.5, distance.into()) as f32;
            let wrong = (found / expected - 1.0).abs();
            assert!(wrong < 0.05, "{distance}: {found} for {expected}");
            let behind = rectangle.irradiance(Vec3::Y * 50.0, Vec3::NEG_Y, 0.0);
            assert_eq!(behind, Vec3::ZERO);
        }
    }
}

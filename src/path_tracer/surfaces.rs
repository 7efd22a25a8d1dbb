//! The interface between a scene and the path tracer.

use bevy::math::Vec3;

/// How far a ray starts above the surface that it leaves, in metres.
pub(super) const OFFSET: f32 = 1e-4;

/// The surfaces of a scene.
pub trait Surfaces: Sync {
    /// The first surface that a ray hits.
    fn closest(&self, ray: Ray) -> Option<Hit>;

    /// Whether a ray hits a surface within this distance.
    fn blocked(&self, ray: Ray, distance: f32) -> bool;

    /// Area of all emissive surfaces in square metres.
    fn emissive_area(&self) -> f32 {
        0.0
    }

    /// A point of the emissive surfaces, all of which are as likely, from three numbers between 0 and 1.
    fn emitter(&self, _at: [f32; 3]) -> Option<EmitterPoint> {
        None
    }
}

/// A half line.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin in metres.
    pub origin: Vec3,
    /// A unit vector.
    pub direction: Vec3,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Its distance from the origin of the ray, in metres.
    pub distance: f32,
    /// The point, in metres.
    pub position: Vec3,
    /// The normal of the geometry on the side of the ray, a unit vector.
    pub face_normal: Vec3,
    /// The normal that light is reflected about, a unit vector.
    pub normal: Vec3,
    /// Diffuse albedo per channel, 0 to 1.
    pub albedo: Vec3,
    /// Radiance that the surface emits, in cd/m².
    pub emission: Vec3,
}

impl Hit {
    /// A ray that leaves the surface.
    pub(super) fn ray(&self, direction: Vec3) -> Ray {
        Ray {
            origin: self.position + OFFSET * self.face_normal,
            direction,
        }
    }
}

/// A point of an emissive surface.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPoint {
    /// The point, in metres.
    pub position: Vec3,
    /// The normal of its side that emits, a unit vector.
    pub normal: Vec3,
    /// Radiance that it emits, in cd/m².
    pub emission: Vec3,
}

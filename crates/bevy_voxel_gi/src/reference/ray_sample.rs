//! The light that a ray receives from its hit.

use super::{
    grid::{FACE_STEPS, FACES},
    hit::{Hit, PassedSurface},
    voxels::Voxels,
};
use glam::Vec3;

/// The result of tracing a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RaySample<T> {
    /// The ray hit the front of a surface, or nothing: the light from there.
    Light(T),
    /// The ray hit the back of a single-sided surface, which is black, at a distance in voxels.
    BackFace(f32),
    /// The ray hit a sub-voxel without a front-facing surface, though its voxel has one, as inside a thin
    /// wall: the sample is invalid.
    Invalid,
}

impl<T> RaySample<T> {
    /// Converts the light.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> RaySample<U> {
        match self {
            Self::Light(light) => RaySample::Light(change(light)),
            Self::BackFace(distance) => RaySample::BackFace(distance),
            Self::Invalid => RaySample::Invalid,
        }
    }

    /// Returns whether the ray ends at a back or in a wall, as all rays in a solid do.
    pub fn is_enclosed(&self) -> bool {
        !matches!(self, Self::Light(_))
    }

    /// Returns whether the ray may start in a solid, close to its surface.
    ///
    /// Only the region near the surface of a large solid matters: receivers outside interpolate with it.
    pub fn is_inside_geometry(&self) -> bool {
        match self {
            Self::Light(_) => false,
            Self::BackFace(distance) => *distance < NEAR,
            Self::Invalid => true,
        }
    }
}

/// A back face that is hit nearer than this, in voxels, may belong to the solid in which the ray starts.
pub const NEAR: f32 = 1.5;

/// Returns the weight of each face of a hit voxel, 1 in total.
///
/// The weight is the squared cosine if the face's surface is front-facing and the hit sub-voxel is one of
/// that surface's own: otherwise the outside of a thin wall would be visible from inside.
pub fn face_weights(voxels: &Voxels, hit: &Hit, direction: Vec3) -> RaySample<[f32; 6]> {
    let mut is_back_face = true;
    let weights = [0, 1, 2, 3, 4, 5].map(|face| {
        if !hit.is_front_facing(voxels, direction, face) {
            return 0.0;
        }
        is_back_face = false;
        let is_own = voxels.is_outermost(hit.sub_voxel, FACE_STEPS[face]);
        let cosine = direction.dot(FACES[face]);
        if is_own { cosine * cosine } else { 0.0 }
    });
    let sum: f32 = weights.iter().sum();
    if sum > 0.0 {
        RaySample::Light(weights.map(|w| w / sum))
    } else if is_back_face {
        RaySample::BackFace(hit.distance)
    } else {
        RaySample::Invalid
    }
}

/// Returns the radiance of a hit, where `radiance` is per voxel and face. In the edge between two
/// surfaces it is that of the surface that the ray passed.
pub fn hit_radiance(
    voxels: &Voxels,
    hit: &Hit,
    direction: Vec3,
    radiance: impl Fn(usize, usize) -> Vec3,
) -> RaySample<Vec3> {
    let sample = face_weights(voxels, hit, direction).map(|weights| {
        (0..6)
            .map(|face| radiance(hit.voxel, face) * weights[face])
            .sum()
    });
    match (sample, hit.passed) {
        (RaySample::Invalid, Some(PassedSurface::Front(voxel, face))) => {
            RaySample::Light(radiance(voxel, face))
        }
        (RaySample::Invalid, Some(PassedSurface::Back)) => RaySample::BackFace(hit.distance),
        _ => sample,
    }
}

//! The light that a ray receives from its hit.

use super::{
    grid::{FACE_STEPS, FACES},
    key::key_normal,
    trace::{Grazed, Hit},
    voxels::Voxels,
};
use glam::Vec3;

/// The result of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen<T> {
    /// The ray hit the front of a surface, or nothing: the light from there.
    Light(T),
    /// The ray hit the back of a single-sided surface, which is black, at a distance in voxels.
    Back(f32),
    /// The ray hit a sub-voxel without a front-facing surface, though its voxel has one, as inside a thin
    /// wall: the sample is invalid.
    Unclear,
}

impl<T> Seen<T> {
    /// Converts the light.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Seen<U> {
        match self {
            Self::Light(light) => Seen::Light(change(light)),
            Self::Back(distance) => Seen::Back(distance),
            Self::Unclear => Seen::Unclear,
        }
    }

    /// Returns whether the ray may start inside geometry.
    ///
    /// Only the region near the surface of a large solid matters: receivers outside interpolate with it.
    pub fn is_enclosed(&self) -> bool {
        match self {
            Self::Light(_) => false,
            Self::Back(distance) => *distance < NEAR,
            Self::Unclear => true,
        }
    }
}

/// A back face that is hit nearer than this, in voxels, may belong to the solid in which the ray starts.
pub const NEAR: f32 = 4.0;

/// Returns the weight of each face of a hit voxel, 1 in total.
///
/// The weight is the squared cosine if the face's surface is front-facing and the hit sub-voxel is one of
/// that surface's own: otherwise the outside of a thin wall would be visible from inside.
pub fn seen_faces(voxels: &Voxels, hit: &Hit, direction: Vec3) -> Seen<[f32; 6]> {
    let mut is_back = true;
    let weights = [0, 1, 2, 3, 4, 5].map(|face| {
        if !is_turned(voxels, hit, direction, face) {
            return 0.0;
        }
        is_back = false;
        let is_own = voxels.is_outermost(hit.sub_voxel, FACE_STEPS[face]);
        let cosine = direction.dot(FACES[face]);
        if is_own { cosine * cosine } else { 0.0 }
    });
    let sum: f32 = weights.iter().sum();
    if sum > 0.0 {
        Seen::Light(weights.map(|w| w / sum))
    } else if is_back {
        Seen::Back(hit.distance)
    } else {
        Seen::Unclear
    }
}

/// Returns the radiance of a hit, where `radiance` is per voxel and face. In the edge between two
/// surfaces it is that of the surface that the ray passed.
pub fn seen_light(
    voxels: &Voxels,
    hit: &Hit,
    direction: Vec3,
    radiance: impl Fn(usize, usize) -> Vec3,
) -> Seen<Vec3> {
    let seen = seen_faces(voxels, hit, direction).map(|weights| {
        (0..6)
            .map(|face| radiance(hit.voxel, face) * weights[face])
            .sum()
    });
    match (seen, hit.grazed) {
        (Seen::Unclear, Some(Grazed::Front(voxel, face))) => Seen::Light(radiance(voxel, face)),
        (Seen::Unclear, Some(Grazed::Back)) => Seen::Back(hit.distance),
        _ => seen,
    }
}

/// Returns whether a face of the hit voxel has a front-facing surface.
pub fn is_turned(voxels: &Voxels, hit: &Hit, direction: Vec3, face: usize) -> bool {
    let key = voxels.keys[hit.voxel][face];
    key != 0 && direction.dot(FACES[face]) < 0.0 && direction.dot(key_normal(key)) < 0.0
}

/// Returns whether a face of the hit voxel has a back-facing surface, which the ray reaches from behind.
pub fn is_away(voxels: &Voxels, hit: &Hit, direction: Vec3, face: usize) -> bool {
    let key = voxels.keys[hit.voxel][face];
    key != 0 && direction.dot(FACES[face]) > 0.0 && direction.dot(key_normal(key)) > 0.0
}

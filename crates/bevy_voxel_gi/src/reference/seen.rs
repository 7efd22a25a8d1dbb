//! What a ray sees where it ends.

use super::{
    grid::{FACE_STEPS, FACES},
    key::key_normal,
    trace::{Grazed, Hit},
    voxels::Voxels,
};
use glam::Vec3;

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen<T> {
    /// The front of a surface, or nothing: what comes from there.
    Light(T),
    /// The back of a surface with one side, which is black, after a distance in voxels.
    Back(f32),
    /// A sub-voxel of no surface turned to the ray, though its voxel has one, as inside of a thin wall:
    /// that tells nothing.
    Unclear,
}

impl<T> Seen<T> {
    /// The same with another light.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> Seen<U> {
        match self {
            Self::Light(light) => Seen::Light(change(light)),
            Self::Back(distance) => Seen::Back(distance),
            Self::Unclear => Seen::Unclear,
        }
    }

    /// Whether the ray may have begun inside of something.
    ///
    /// Of a large solid only what is near its surface matters: receivers outside interpolate with it.
    pub fn is_enclosed(&self) -> bool {
        match self {
            Self::Light(_) => false,
            Self::Back(distance) => *distance < NEAR,
            Self::Unclear => true,
        }
    }
}

/// A back that is met nearer than this, in voxels, may belong to the solid in which the ray began.
pub const NEAR: f32 = 4.0;

/// By how much each face of a hit voxel is what a ray sees, 1 in all.
///
/// A face counts by its squared cosine, if its surface is turned to the ray and the hit sub-voxel is one
/// of that surface's own: otherwise the inside of a thin wall would show its outside.
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

/// What comes from a hit: radiance per voxel and face, in the edge between two surfaces of the one
/// that the ray grazed.
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

/// Whether a face of the voxel that a ray meets has a surface that is turned to the ray.
pub fn is_turned(voxels: &Voxels, hit: &Hit, direction: Vec3, face: usize) -> bool {
    let key = voxels.keys[hit.voxel][face];
    key != 0 && direction.dot(FACES[face]) < 0.0 && direction.dot(key_normal(key)) < 0.0
}

/// The same of a surface that is turned away from the ray, which comes from behind.
pub fn is_away(voxels: &Voxels, hit: &Hit, direction: Vec3, face: usize) -> bool {
    let key = voxels.keys[hit.voxel][face];
    key != 0 && direction.dot(FACES[face]) > 0.0 && direction.dot(key_normal(key)) > 0.0
}

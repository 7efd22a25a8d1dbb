//! Ray directions, and the hash that rotates them differently in each voxel.

use glam::Vec3;
use std::f32::consts::TAU;

/// 2 pi (1 - 1 / golden ratio): the rotation from each ray to the next.
pub const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Returns a pseudo-random integer (M. Jarzynski and M. Olano, *Hash Functions for GPU Rendering*, 2020:
/// pcg).
pub fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Returns [`hash`] as a number from 0 to below 1.
pub fn hash_unit(value: u32) -> f32 {
    (hash(value) >> 8) as f32 / (1 << 24) as f32
}

/// Returns two unit vectors that form an orthonormal basis with a unit vector
/// (T. Duff et al., *Building an Orthonormal Basis, Revisited*, 2017).
pub fn tangents(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// Returns ray `i` of `count` about a normal, with a density in proportion to the cosine: the mean of the
/// rays' radiance, times pi, is the irradiance.
///
/// `rotation`, 0 to 1, rotates all of them about the normal.
pub fn cosine_ray(i: u32, count: u32, rotation: f32, normal: Vec3) -> Vec3 {
    let squared = (i as f32 + 0.5) / count as f32;
    let angle = i as f32 * GOLDEN_ANGLE + rotation * TAU;
    let (t, b) = tangents(normal);
    let r = squared.sqrt();
    t * (r * angle.cos()) + b * (r * angle.sin()) + normal * (1.0 - squared).max(0.0).sqrt()
}

/// Returns ray `i` of `count`, distributed uniformly over the sphere.
///
/// `rotation`, 0 to 1, rotates all of them about z.
pub fn sphere_ray(i: u32, count: u32, rotation: f32) -> Vec3 {
    let z = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
    let angle = i as f32 * GOLDEN_ANGLE + rotation * TAU;
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * angle.cos(), r * angle.sin(), z)
}

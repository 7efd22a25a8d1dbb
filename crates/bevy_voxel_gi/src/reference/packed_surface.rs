//! The packed surface of a voxel's face: 32 bits of which the largest value is kept (`atomicMax`).
//!
//! | bits | content |
//! | --- | --- |
//! | 12..32 | weight, by the area of the surface in the voxel, 1 to 2^20 - 1 |
//! | 0..12 | normal, octahedral, 6 + 6 bits |
//!
//! 0 means that the face has no surface. Faces of a voxel with the same normal have one surface.

use glam::{Vec2, Vec3};

/// The weight of a packed surface is this, times powers of its area, in units of a voxel's face, and of its cosine. The
/// steps are coarse: of surfaces that are nearly equal the normal's bits choose one, rather than the slope, which would
/// flatten hills. The powers have small errors on hills and in a scene of curved meshes.
pub const WEIGHT_SCALE: f32 = 256.0;

/// Largest weight of a packed surface.
pub const MAX_WEIGHT: u32 = (1 << 20) - 1;

/// Least cosine between a surface's normal and a face that it can represent.
pub const MIN_FACE_COSINE: f32 = 0.125;

const NORMAL_STEPS: f32 = 62.0; // even: axes are exact

/// Packs a surface of which an area is in a voxel, in units of a voxel's face, at a cosine to the face.
pub fn pack_surface(area: f32, cosine: f32, normal: Vec3) -> u32 {
    let weight = (area.powf(0.7) * cosine.abs().powf(0.9) * WEIGHT_SCALE).round();
    (weight as u32).clamp(1, MAX_WEIGHT) << 12 | pack_normal(normal)
}

/// Returns the normal of a packed surface.
pub fn packed_normal(packed: u32) -> Vec3 {
    unpack_normal(packed_normal_bits(packed))
}

/// Returns the bits of a packed surface's normal, which are the same in all faces that a surface represents.
pub fn packed_normal_bits(packed: u32) -> u32 {
    packed & 0xfff
}

/// Packs a unit vector into 12 bits (octahedral map).
pub fn pack_normal(normal: Vec3) -> u32 {
    let flat = normal / normal.abs().element_sum();
    let mut p = Vec2::new(flat.x, flat.y);
    if flat.z < 0.0 {
        p = (1.0 - Vec2::new(p.y, p.x).abs()) * sign(p);
    }
    let q = ((p * 0.5 + 0.5) * NORMAL_STEPS + 0.5).floor();
    q.x as u32 | (q.y as u32) << 6
}

/// Unpacks a normal, the inverse of [`pack_normal`].
pub fn unpack_normal(bits: u32) -> Vec3 {
    let p = Vec2::new((bits & 63) as f32, (bits >> 6 & 63) as f32) / NORMAL_STEPS * 2.0 - 1.0;
    let z = 1.0 - p.abs().element_sum();
    let fold = (-z).max(0.0);
    let p = p - fold * sign(p);
    Vec3::new(p.x, p.y, z).normalize()
}

fn sign(v: Vec2) -> Vec2 {
    Vec2::select(v.cmplt(Vec2::ZERO), Vec2::NEG_ONE, Vec2::ONE)
}

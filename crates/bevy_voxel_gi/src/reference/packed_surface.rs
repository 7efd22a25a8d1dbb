//! The packed surface of a voxel's face: 32 bits of which the largest value is kept (`atomicMax`).
//!
//! | bits | content |
//! | --- | --- |
//! | 24..32 | weight, how much of the voxel it fills, 1 to 255 |
//! | 12..24 | normal, octahedral, 6 + 6 bits |
//! | 0..12 | material |
//!
//! 0 means that the face has no surface.

use glam::{Vec2, Vec3};

/// Number of distinct materials in a volume.
pub const MATERIALS: u32 = 1 << 12;

/// The weight of a packed surface is the number of sub-voxels times the squared cosine, times this.
pub const WEIGHT_SCALE: f32 = 8.0;

/// Least cosine between a surface's normal and a face that it can represent.
pub const MIN_FACE_COSINE: f32 = 0.125;

const NORMAL_STEPS: f32 = 62.0; // even: axes are exact

/// Packs a surface that fills `sub_voxels` of a voxel, at a cosine to the face.
pub fn pack_surface(sub_voxels: u32, cosine: f32, normal: Vec3, material: u32) -> u32 {
    let weight = (sub_voxels as f32 * cosine * cosine * WEIGHT_SCALE).ceil();
    (weight.clamp(1.0, 255.0) as u32) << 24
        | pack_normal(normal) << 12
        | material.min(MATERIALS - 1)
}

/// Returns the normal of a packed surface.
pub fn packed_normal(packed: u32) -> Vec3 {
    unpack_normal(packed >> 12 & 0xfff)
}

/// Returns the material of a packed surface.
pub fn packed_material(packed: u32) -> u32 {
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

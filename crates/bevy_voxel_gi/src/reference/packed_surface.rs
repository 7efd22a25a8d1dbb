//! The packed surface of a voxel's face: 32 bits of which the largest value is kept (`atomicMax`).
//!
//! | bits | content |
//! | --- | --- |
//! | 22..32 | weight, by the area of the surface in the voxel, 1 to 2^10 - 1 |
//! | 12..22 | height of its plane above the centre of the voxel, along the normal |
//! | 0..12 | normal, octahedral, 6 + 6 bits |
//!
//! 0 means that the face has no surface. Faces of a voxel with the same normal have one surface.

use super::voxels::SUB_VOXELS;
use glam::{Vec2, Vec3};

/// The weight of a packed surface is this, times powers of its area, in units of a voxel's face, and of its cosine. The
/// steps are coarse: of surfaces that are nearly equal the foremost is chosen, rather than the slope, which would
/// flatten hills. The powers have small errors on hills and in a scene of curved meshes.
pub const WEIGHT_SCALE: f32 = 256.0;

/// Largest weight of a packed surface.
pub const MAX_WEIGHT: u32 = (1 << 10) - 1;

/// Steps of height in a voxel's edge. Planes that cross a voxel are at most the half of its diagonal from its centre.
const HEIGHT_STEPS: f32 = 590.0;

/// More than the errors of two packed heights, and than that of one and [`SINK`](super::overlap::SINK), in voxels.
pub const HEIGHT_ERROR: f32 = 1.0 / 512.0;

/// Least cosine between a surface's normal and a face that it can represent.
pub const MIN_FACE_COSINE: f32 = 0.125;

const NORMAL_STEPS: f32 = 62.0; // even: axes are exact

/// Second largest component of a normal up to which its plane is along the grid. In its voxel it leaves one that is by
/// hardly more than [`HEIGHT_ERROR`].
const MAX_TILT: f32 = 0.002;

/// The least one that is packed as a normal beside the axis.
const NEXT_TILT: f32 = 0.02;

/// Packs a surface of which an area is in a voxel, in units of a voxel's face, at a cosine to the face. `height` is that
/// of its plane above the voxel's centre along the normal, in voxels.
pub fn pack_surface(area: f32, cosine: f32, normal: Vec3, height: f32) -> u32 {
    let weight = (area.powf(0.7) * cosine.abs().powf(0.9) * WEIGHT_SCALE).round();
    let height = (height * HEIGHT_STEPS + 512.5).clamp(0.0, 1023.0);
    (weight as u32).clamp(1, MAX_WEIGHT) << 22 | (height as u32) << 12 | pack_normal(normal)
}

/// The plane of a packed surface in its voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vec3,
    /// Distance from the voxel's centre along the normal, in voxels. The triangles are in front of it by
    /// [`SINK`](super::overlap::SINK), so that the plane crosses the sub-voxels that they fill.
    pub height: f32,
}

impl Plane {
    /// Returns the plane of a packed surface.
    pub fn new(packed: u32) -> Self {
        Self {
            normal: packed_normal(packed),
            height: ((packed >> 12 & 1023) as f32 - 512.0) / HEIGHT_STEPS,
        }
    }

    /// Returns the height of a position above the plane; the position is from the centre of the voxel.
    pub fn height_of(&self, position: Vec3) -> f32 {
        self.normal.dot(position) - self.height
    }

    /// Returns half of the height of a sub-voxel along the normal.
    pub fn reach(&self) -> f32 {
        0.5 / SUB_VOXELS as f32 * self.normal.abs().element_sum()
    }

    /// Returns whether the plane is that of all of its surface in the voxel: along the grid the packed normal is exact.
    /// Other surfaces may be curved.
    pub fn is_exact(&self) -> bool {
        self.normal.abs().max_element() > 0.9999
    }

    /// Returns whether the plane is exact and crosses a sub-voxel, by its centre from that of the voxel, or is less than
    /// `margin` behind it.
    pub fn crosses(&self, center: Vec3, margin: f32) -> bool {
        let reach = self.reach();
        self.is_exact() && (-reach..=reach + margin).contains(&self.height_of(center))
    }
}

/// Returns the normal of a packed surface.
pub fn packed_normal(packed: u32) -> Vec3 {
    unpack_normal(packed_normal_bits(packed))
}

/// Returns the bits of a packed surface's normal, which are the same in all faces that a surface represents.
pub fn packed_normal_bits(packed: u32) -> u32 {
    packed & 0xfff
}

/// Packs a unit vector into 12 bits (octahedral map). Only what is along the grid, within 0.002, is packed as an axis.
pub fn pack_normal(normal: Vec3) -> u32 {
    let normal = beside_axis(normal);
    let flat = normal / normal.abs().element_sum();
    let mut p = Vec2::new(flat.x, flat.y);
    if flat.z < 0.0 {
        p = (1.0 - Vec2::new(p.y, p.x).abs()) * sign(p);
    }
    let q = ((p * 0.5 + 0.5) * NORMAL_STEPS + 0.5).floor();
    q.x as u32 | (q.y as u32) << 6
}

/// Moves a vector that is nearly along an axis to the next packed normal beside it.
fn beside_axis(normal: Vec3) -> Vec3 {
    let size = normal.abs();
    let (most, least) = (size.max_element(), size.min_element());
    let tilt = size.element_sum() - most - least;
    if tilt <= MAX_TILT || tilt >= NEXT_TILT {
        return normal;
    }
    Vec3::select(
        size.cmpeq(Vec3::splat(most)),
        normal,
        normal * (NEXT_TILT / tilt),
    )
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

//! The hit of a ray, and the orientation of the hit voxel's surfaces.

use super::{grid::FACES, packed_surface::packed_normal, voxels::Voxels};
use glam::{IVec3, Vec3};

/// The hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the voxel.
    pub voxel: usize,
    /// The sub-voxel, counted from the volume's lowest corner.
    pub sub_voxel: IVec3,
    /// Distance along the ray, in voxels.
    pub distance: f32,
    /// The surface that the ray passed in the sub-voxel just before.
    pub passed: Option<PassedSurface>,
}

/// A surface that a ray passes without a hit in one of its sub-voxels: a near miss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassedSurface {
    /// The ray stays in front of the surface: index of the voxel, and face.
    Front(usize, usize),
    /// The ray stays behind the surface.
    Back,
    /// The ray was in front of the back-facing surface when it entered the sub-voxel, and leaves it.
    Left,
}

impl Hit {
    /// Returns whether a face of the hit voxel has a front-facing surface.
    pub fn is_front_facing(&self, voxels: &Voxels, direction: Vec3, face: usize) -> bool {
        let packed = voxels.packed_surfaces[self.voxel][face];
        packed != 0
            && direction.dot(FACES[face]) < 0.0
            && direction.dot(packed_normal(packed)) < 0.0
    }

    /// Returns whether a face of the hit voxel has a back-facing surface, which the ray reaches from
    /// behind.
    pub fn is_back_facing(&self, voxels: &Voxels, direction: Vec3, face: usize) -> bool {
        let packed = voxels.packed_surfaces[self.voxel][face];
        packed != 0
            && direction.dot(FACES[face]) > 0.0
            && direction.dot(packed_normal(packed)) > 0.0
    }
}

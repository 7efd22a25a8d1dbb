//! Voxelisation of triangles (thesis 6.4 and 6.5).
//!
//! A voxel stores which of its 4 x 4 x 4 sub-voxels triangles overlap, and for each of its six faces the
//! surface that represents everything facing that side (6.5.2, 6.5.3: a single average would mix the two
//! sides of a wall).

use super::{
    grid::{FACES, VolumeGrid},
    overlap::TriangleOverlap,
    packed_surface::{MIN_FACE_COSINE, pack_surface},
};
use glam::{IVec3, Vec3};

/// Number of sub-voxels along an edge of a voxel.
pub const SUB_VOXELS: i32 = 4;

/// Reflectance and emission of a surface, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Material {
    /// Diffuse reflectance, 0 to 1.
    pub albedo: Vec3,
    /// Emitted radiance, in cd/m^2.
    pub emission: Vec3,
}

/// A triangle in world space, in metres; the counter-clockwise side is its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Positions of its corners.
    pub corners: [Vec3; 3],
    /// Index of its material.
    pub material: u32,
    /// Whether its back is a surface, too.
    pub double_sided: bool,
}

/// The voxelised scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    /// Placement of the voxels.
    pub grid: VolumeGrid,
    /// Per voxel: bit x + 4 y + 16 z is set if sub-voxel (x, y, z) is occupied.
    pub masks: Vec<u64>,
    /// Per voxel and face: the packed surface, 0 without one.
    pub packed_surfaces: Vec<[u32; 6]>,
}

/// Returns the bit of a sub-voxel in a mask.
pub fn sub_voxel_bit(sub_voxel: IVec3) -> u64 {
    1 << (sub_voxel.x + 4 * sub_voxel.y + 16 * sub_voxel.z)
}

impl Voxels {
    /// Creates voxels without surfaces.
    pub fn empty(grid: VolumeGrid) -> Self {
        Self {
            grid,
            masks: vec![0; grid.len()],
            packed_surfaces: vec![[0; 6]; grid.len()],
        }
    }

    /// Voxelises triangles conservatively, in contrast to [`Voxels::from_points`]. Those without an area or that are
    /// not finite are skipped.
    pub fn new(grid: VolumeGrid, triangles: &[Triangle]) -> Self {
        let mut voxels = Self::empty(grid);
        for triangle in triangles {
            voxels.add(triangle);
        }
        voxels
    }

    fn add(&mut self, triangle: &Triangle) {
        let corners = triangle.corners.map(|v| self.grid.to_grid(v));
        let Some(overlap) = TriangleOverlap::new(corners) else {
            return;
        };
        let last = self.grid.resolution as f32 - 1.0;
        let low = overlap.min.floor();
        let high = overlap.max.floor();
        if low.max_element() > last || high.min_element() < 0.0 {
            return;
        }
        let low = low.max(Vec3::ZERO).as_ivec3();
        let high = high.min(Vec3::splat(last)).as_ivec3();
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let voxel = IVec3::new(x, y, z);
                    if overlap.overlaps(voxel.as_vec3(), 1.0) {
                        let overlaps = |min, size| overlap.overlaps(min, size);
                        self.add_to(voxel, &overlap, triangle, overlaps);
                    }
                }
            }
        }
    }

    /// Adds a triangle to a voxel, in those of its sub-voxels, by lowest corner and edge, that `is_in` accepts.
    pub(super) fn add_to(
        &mut self,
        voxel: IVec3,
        overlap: &TriangleOverlap,
        triangle: &Triangle,
        is_in: impl Fn(Vec3, f32) -> bool,
    ) {
        let size = 1.0 / SUB_VOXELS as f32;
        let mut mask = 0;
        for bit in 0..64 {
            let sub = IVec3::new(bit % 4, bit / 4 % 4, bit / 16);
            if is_in(voxel.as_vec3() + sub.as_vec3() * size, size) {
                mask |= 1 << bit;
            }
        }
        let Some(index) = self.grid.index(voxel).filter(|_| mask != 0) else {
            return;
        };
        self.masks[index] |= mask;
        for (face, direction) in FACES.into_iter().enumerate() {
            let cosine = overlap.normal.dot(direction);
            if cosine > MIN_FACE_COSINE || (triangle.double_sided && -cosine > MIN_FACE_COSINE) {
                let packed = pack_surface(
                    mask.count_ones(),
                    cosine,
                    overlap.normal * cosine.signum(),
                    triangle.material,
                );
                self.packed_surfaces[index][face] = self.packed_surfaces[index][face].max(packed);
            }
        }
    }

    /// Returns whether a sub-voxel is occupied, counted from the volume's lowest corner; none is outside.
    pub fn is_occupied(&self, sub_voxel: IVec3) -> bool {
        self.grid
            .index(sub_voxel.div_euclid(IVec3::splat(SUB_VOXELS)))
            .is_some_and(|i| {
                self.masks[i] & sub_voxel_bit(sub_voxel.rem_euclid(IVec3::splat(SUB_VOXELS))) != 0
            })
    }

    /// Returns whether an occupied sub-voxel is the outermost one of its voxel in a direction, and the
    /// sub-voxel in front of it in the next voxel is empty.
    pub fn is_outermost(&self, sub_voxel: IVec3, step: IVec3) -> bool {
        let voxel = sub_voxel.div_euclid(IVec3::splat(SUB_VOXELS));
        let mut at = sub_voxel + step;
        while at.div_euclid(IVec3::splat(SUB_VOXELS)) == voxel {
            if self.is_occupied(at) {
                return false;
            }
            at += step;
        }
        !self.is_occupied(at)
    }
}

//! The light in the volume as receivers sample it: six irradiances per voxel (Bevy's irradiance volume).

use super::{
    grid::VolumeGrid,
    surface::{CLEARANCE, Surface, is_clear},
    voxels::{SUB_VOXELS, Voxels},
};
use glam::{IVec3, Vec3, Vec4};

/// Weight of a voxel that a receiver does not see, against 1: it counts where no other does.
pub const HIDDEN: f32 = 1.0 / 1024.0;

/// Steps towards the viewer out of a sub-voxel that something else fills as well.
const ESCAPE_STEPS: u32 = 3;
/// Length of such a step, in voxels.
const ESCAPE: f32 = 0.125;

/// Irradiance per voxel and face, each with a weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Where the voxels are.
    pub grid: VolumeGrid,
    /// Per voxel and face: irradiance times weight, and weight.
    pub texels: Vec<[Vec4; 6]>,
}

impl Field {
    /// Without light and without weight.
    pub fn empty(grid: VolumeGrid) -> Self {
        Self {
            grid,
            texels: vec![[Vec4::ZERO; 6]; grid.len()],
        }
    }

    /// Stores what was found for surfaces: a value times a weight, and the weight.
    pub(super) fn put(&mut self, surfaces: &[Surface], values: &[Vec4]) {
        for (surface, value) in surfaces.iter().zip(values) {
            for face in surface.faces() {
                self.texels[surface.voxel][face] = *value;
            }
        }
    }

    /// Trilinear between voxel centres, clamped at the border; grid coordinates.
    pub fn sample(&self, position: Vec3, face: usize) -> Vec4 {
        let last = self.grid.resolution as f32 - 1.0;
        let p = (position - 0.5).clamp(Vec3::ZERO, Vec3::splat(last));
        let low = p.floor();
        let f = p - low;
        let mut sum = Vec4::ZERO;
        for corner in 0..8 {
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let weights = Vec3::select(step.cmpeq(IVec3::ONE), f, 1.0 - f);
            if let Some(index) = self.grid.index(low.as_ivec3() + step) {
                sum += self.texels[index][face] * (weights.x * weights.y * weights.z);
            }
        }
        sum
    }

    /// Irradiance of a surface, in lux: an ambient cube.
    ///
    /// `position` in metres, `normal` a unit vector; the position is moved along it by `shift` voxels.
    pub fn irradiance(&self, position: Vec3, normal: Vec3, shift: f32) -> Vec3 {
        let at = self.grid.to_grid(position) + normal * shift;
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            let face = 2 * axis + usize::from(normal[axis] < 0.0);
            sum += self.sample(at, face) * normal[axis].powi(2);
        }
        sum.truncate() / sum.w.max(1e-12)
    }

    /// The same with the eight voxels around looked for: those behind something count by
    /// [`HIDDEN`].
    ///
    /// `to_viewer` is a unit vector from the position to who looks at it: in a sub-voxel that a
    /// wall fills in part, it tells on which side of the wall the position is.
    pub fn irradiance_seen(
        &self,
        voxels: &Voxels,
        position: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
    ) -> Vec3 {
        let place = self.grid.to_grid(position);
        // In front of the sub-voxels that the surface itself fills.
        let lift = normal.abs().element_sum() / SUB_VOXELS as f32 + CLEARANCE;
        let mut eye = place + normal * lift;
        let is_inside = |at: Vec3| voxels.is_touched((at * SUB_VOXELS as f32).floor().as_ivec3());
        for _ in 0..ESCAPE_STEPS {
            if is_inside(eye) {
                eye += to_viewer * ESCAPE;
            }
        }
        if is_inside(eye) {
            return self.irradiance(position, normal, 0.0);
        }
        let last = self.grid.resolution as f32 - 1.0;
        let p = (place - 0.5).clamp(Vec3::ZERO, Vec3::splat(last));
        let low = p.floor();
        let f = p - low;
        let mut sum = Vec4::ZERO;
        for corner in 0..8 {
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let voxel = low.as_ivec3() + step;
            let Some(index) = self.grid.index(voxel) else {
                continue;
            };
            let mut weight = Vec3::select(step.cmpeq(IVec3::ONE), f, 1.0 - f).element_product();
            // Along the surface, as far as the middle of the voxel.
            let way = voxel.as_vec3() + 0.5 - eye;
            if !is_clear(voxels, eye, eye + way - normal * normal.dot(way)) {
                weight *= HIDDEN;
            }
            for axis in 0..3 {
                let face = 2 * axis + usize::from(normal[axis] < 0.0);
                sum += self.texels[index][face] * (normal[axis].powi(2) * weight);
            }
        }
        sum.truncate() / sum.w.max(1e-12)
    }
}

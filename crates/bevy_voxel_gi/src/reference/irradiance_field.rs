//! The light in the volume as receivers sample it: six irradiances per voxel, as in Bevy's irradiance
//! volumes.

use super::{grid::VolumeGrid, surface::Surface};
use glam::{IVec3, Vec3, Vec4};

/// Irradiance per voxel and face, each with a weight.
#[derive(Clone, Debug, PartialEq)]
pub struct IrradianceField {
    /// Placement of the voxels.
    pub grid: VolumeGrid,
    /// Per voxel and face: irradiance times weight, and weight.
    pub texels: Vec<[Vec4; 6]>,
}

impl IrradianceField {
    /// Creates a field without light, with weights of 0.
    pub fn empty(grid: VolumeGrid) -> Self {
        Self {
            grid,
            texels: vec![[Vec4::ZERO; 6]; grid.len()],
        }
    }

    /// Stores the values of surfaces: irradiance times weight, and weight.
    pub(super) fn put(&mut self, surfaces: &[Surface], values: &[Vec4]) {
        for (surface, value) in surfaces.iter().zip(values) {
            for face in surface.faces() {
                self.texels[surface.voxel][face] = *value;
            }
        }
    }

    /// Interpolates trilinearly between voxel centres, clamped at the border. `position` is in grid
    /// coordinates.
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

    /// Returns the irradiance of a surface in lux, from an ambient cube.
    ///
    /// `position` is in metres, `normal` is a unit vector, along which the position is moved by `shift`
    /// voxels.
    pub fn irradiance(&self, position: Vec3, normal: Vec3, shift: f32) -> Vec3 {
        let at = self.grid.to_grid(position) + normal * shift;
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            let face = 2 * axis + usize::from(normal[axis] < 0.0);
            sum += self.sample(at, face) * normal[axis].powi(2);
        }
        sum.truncate() / sum.w.max(1e-12)
    }
}

//! The light in the volume as receivers sample it: six irradiances per voxel, as in Bevy's irradiance
//! volumes.

use super::{
    grid::VolumeGrid,
    surface::{CLEARANCE, Surface},
    voxels::{SUB_VOXELS, Voxels},
};
use glam::{IVec3, Vec3, Vec4};

/// Weight of a voxel that is not visible, relative to 1: it matters only where no voxel is visible.
pub const HIDDEN: f32 = 1.0 / 1024.0;

/// A voxel is hidden if its ray passes through this length of occupied sub-voxels, in sub-voxel edges; a
/// shorter length hides a part of it, so that light changes gradually beside small things.
const OPAQUE: f32 = 0.5;

/// If something else also fills the sub-voxel in which the rays start, their origin moves towards the
/// viewer, by at most this distance in voxels.
const FARTHEST: f32 = 0.5;

/// Irradiance per voxel and face, each with a weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Placement of the voxels.
    pub grid: VolumeGrid,
    /// Per voxel and face: irradiance times weight, and weight.
    pub texels: Vec<[Vec4; 6]>,
}

impl Field {
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

    /// Returns the irradiance of a surface in lux with visibility tests of the eight voxels around:
    /// hidden ones are weighted by [`HIDDEN`].
    ///
    /// `to_viewer` is a unit vector from the position to the viewer: in a sub-voxel that a wall fills in
    /// part, it decides which side of the wall the position is on.
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
        let escape = way_out(voxels, eye, to_viewer);
        let clarity = (2.0 - 2.0 * escape / FARTHEST).min(1.0);
        eye += to_viewer * (escape + CLEARANCE);
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
            // Within the plane of the surface, as far as the centre of the voxel.
            let way = voxel.as_vec3() + 0.5 - eye;
            let through = filled(voxels, eye, way - normal * normal.dot(way));
            weight *= 1.0 - clarity * (through / OPAQUE).min(1.0 - HIDDEN);
            for axis in 0..3 {
                let face = 2 * axis + usize::from(normal[axis] < 0.0);
                sum += self.texels[index][face] * (normal[axis].powi(2) * weight);
            }
        }
        sum.truncate() / sum.w.max(1e-12)
    }
}

/// The segments of a path by sub-voxel: fraction of the path, and whether the sub-voxel is occupied.
fn parts(voxels: &Voxels, from: Vec3, way: Vec3) -> impl Iterator<Item = (f32, bool)> {
    let scale = SUB_VOXELS as f32;
    let (start, way) = (from * scale, way * scale);
    let ray = Vec3::select(way.abs().cmplt(Vec3::splat(1e-6)), Vec3::splat(1e-6), way);
    let ahead = Vec3::select(ray.cmpgt(Vec3::ZERO), Vec3::ONE, Vec3::ZERO);
    let step = Vec3::select(ray.cmpgt(Vec3::ZERO), Vec3::ONE, Vec3::NEG_ONE);
    let mut cell = start.floor();
    let mut at = 0.0;
    std::iter::from_fn(move || {
        if at >= 1.0 {
            return None;
        }
        let next = (cell + ahead - start) / ray;
        let end = next.min_element().clamp(at, 1.0);
        let part = (end - at, voxels.is_touched(cell.as_ivec3()));
        at = end;
        let axis = next.min_position();
        cell[axis] += step[axis];
        Some(part)
    })
}

/// Length of a path within occupied sub-voxels, in sub-voxel edges.
fn filled(voxels: &Voxels, from: Vec3, way: Vec3) -> f32 {
    let touched = parts(voxels, from, way).filter(|(_, is_touched)| *is_touched);
    touched.map(|(part, _)| part).sum::<f32>() * way.length() * SUB_VOXELS as f32
}

/// Distance to the end of the occupied sub-voxels around a position, in voxels, at most [`FARTHEST`].
fn way_out(voxels: &Voxels, from: Vec3, direction: Vec3) -> f32 {
    let touched =
        parts(voxels, from, direction * FARTHEST).take_while(|(_, is_touched)| *is_touched);
    touched.map(|(part, _)| part).sum::<f32>() * FARTHEST
}

//! The light in the volume as receivers sample it: six irradiances per voxel (Bevy's irradiance volume).

use super::{
    grid::VolumeGrid,
    surface::{CLEARANCE, Surface},
    voxels::{SUB_VOXELS, Voxels},
};
use glam::{IVec3, Vec3, Vec4};

/// Weight of a voxel that a receiver does not see, against 1: it counts where no other does.
pub const HIDDEN: f32 = 1.0 / 1024.0;

/// What so many sub-voxels' edges of touched sub-voxels are in front of is hidden; less hides a part,
/// so that light changes little by little beside small things.
const OPAQUE: f32 = 0.5;

/// From a sub-voxel that something else fills as well it looks around from farther towards the viewer,
/// but not from farther than this, in voxels.
const FARTHEST: f32 = 0.5;

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
            // Along the surface, as far as the middle of the voxel.
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

/// The parts of a way, from 0 to 1, that are in a sub-voxel each, and whether that is touched.
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

/// How far a way leads through touched sub-voxels, in edges of sub-voxels.
fn filled(voxels: &Voxels, from: Vec3, way: Vec3) -> f32 {
    let touched = parts(voxels, from, way).filter(|(_, is_touched)| *is_touched);
    touched.map(|(part, _)| part).sum::<f32>() * way.length() * SUB_VOXELS as f32
}

/// How far it is out of touched sub-voxels, in voxels, at most [`FARTHEST`].
fn way_out(voxels: &Voxels, from: Vec3, direction: Vec3) -> f32 {
    let touched =
        parts(voxels, from, direction * FARTHEST).take_while(|(_, is_touched)| *is_touched);
    touched.map(|(part, _)| part).sum::<f32>() * FARTHEST
}

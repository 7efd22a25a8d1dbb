//! Irradiance from those voxels that are visible from a position: what pixels read with
//! `Receiver::PerPixel`.

use super::{
    irradiance_field::IrradianceField,
    surface::CLEARANCE,
    voxels::{SUB_VOXELS, Voxels},
};
use glam::{IVec3, Vec3, Vec4};

/// Weight of a voxel that is not visible, relative to 1: it matters only where no voxel is visible.
pub const HIDDEN_WEIGHT: f32 = 1.0 / 65_536.0;

/// A voxel is hidden if its ray passes through this length of occupied sub-voxels, in sub-voxel edges; a
/// shorter length hides a part of it, so that light changes gradually beside small things. At 1, a wall as thin as a
/// sub-voxel hides all; at 1.5, such walls leak.
const OPAQUE_LENGTH: f32 = 1.0;

/// If something else also fills the sub-voxel in which the rays start, their origin moves towards the
/// viewer, by at most this distance in voxels.
const MAX_ESCAPE: f32 = 0.5;

impl IrradianceField {
    /// Returns the irradiance of a surface in lux with visibility tests of the eight voxels around:
    /// hidden ones are weighted by [`HIDDEN_WEIGHT`].
    ///
    /// `to_viewer` is a unit vector from the position to the viewer: in a sub-voxel that a wall fills in
    /// part, it decides which side of the wall the position is on.
    pub fn visible_irradiance(
        &self,
        voxels: &Voxels,
        position: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
    ) -> Vec3 {
        let receiver = self.grid.to_grid(position);
        // In front of the sub-voxels that the surface itself fills.
        let lift = normal.abs().element_sum() / SUB_VOXELS as f32 + CLEARANCE;
        let mut origin = receiver + normal * lift;
        let escape = escape_distance(voxels, origin, to_viewer);
        let clarity = (2.0 - 2.0 * escape / MAX_ESCAPE).min(1.0);
        origin += to_viewer * (escape + CLEARANCE);
        let last = self.grid.resolution as f32 - 1.0;
        let p = (receiver - 0.5).clamp(Vec3::ZERO, Vec3::splat(last));
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
            let offset = voxel.as_vec3() + 0.5 - origin;
            let along = offset - normal * normal.dot(offset);
            let occupied = occupied_length(voxels, origin, along);
            weight *= 1.0 - clarity * (occupied / OPAQUE_LENGTH).min(1.0 - HIDDEN_WEIGHT);
            for axis in 0..3 {
                let face = 2 * axis + usize::from(normal[axis] < 0.0);
                sum += self.texels[index][face] * (normal[axis].powi(2) * weight);
            }
        }
        sum.truncate() / sum.w.max(1e-12)
    }
}

/// The segments of a path by sub-voxel: fraction of the path, and whether the sub-voxel is occupied.
fn segments(voxels: &Voxels, origin: Vec3, path: Vec3) -> impl Iterator<Item = (f32, bool)> {
    let scale = SUB_VOXELS as f32;
    let (start, path) = (origin * scale, path * scale);
    let ray = Vec3::select(path.abs().cmplt(Vec3::splat(1e-6)), Vec3::splat(1e-6), path);
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
        let segment = (end - at, voxels.is_occupied(cell.as_ivec3()));
        at = end;
        let axis = next.min_position();
        cell[axis] += step[axis];
        Some(segment)
    })
}

/// Length of a path within occupied sub-voxels, in sub-voxel edges.
fn occupied_length(voxels: &Voxels, origin: Vec3, path: Vec3) -> f32 {
    let occupied = segments(voxels, origin, path).filter(|(_, is_occupied)| *is_occupied);
    occupied.map(|(fraction, _)| fraction).sum::<f32>() * path.length() * SUB_VOXELS as f32
}

/// Distance to the end of the occupied sub-voxels around a position, in voxels, at most [`MAX_ESCAPE`].
fn escape_distance(voxels: &Voxels, origin: Vec3, direction: Vec3) -> f32 {
    let occupied = segments(voxels, origin, direction * MAX_ESCAPE)
        .take_while(|(_, is_occupied)| *is_occupied);
    occupied.map(|(fraction, _)| fraction).sum::<f32>() * MAX_ESCAPE
}

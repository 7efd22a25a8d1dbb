//! The light in the volume as receivers sample it: six irradiances per voxel, as in Bevy's irradiance
//! volumes.
//!
//! Besides interpolation there are what pixels read with `Receiver::PerPixel`, irradiance from those voxels that are
//! visible from a position, and with `VoxelGiSettings::specular_light`, the specular light of rough surfaces.

use super::{
    grid::VolumeGrid,
    surface::{CLEARANCE, Surface},
    voxels::{SUB_VOXELS, Voxels},
};
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// Weight of a voxel that is not visible, relative to 1: it matters only where no voxel is visible.
pub const HIDDEN_WEIGHT: f32 = 1.0 / 65_536.0;

/// A voxel is hidden if its ray passes through this length of occupied sub-voxels, in sub-voxel edges; a
/// shorter length hides a part of it, so that light changes gradually beside small things. At 1, a wall as thin as a
/// sub-voxel hides all; at 1.5, such walls leak.
const OPAQUE_LENGTH: f32 = 1.0;

/// If something else also fills the sub-voxel in which the rays start, their origin moves towards the
/// viewer, by at most this distance in voxels.
const MAX_ESCAPE: f32 = 0.5;

/// Distances of the planes along the lobe of a rough surface, in voxels.
const DISTANCES: [f32; 3] = [1.5, 3.0, 6.0];

/// Weight of an empty voxel in the light of rough surfaces.
const EMPTY_WEIGHT: f32 = 1.0 / 512.0;

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
        let corners = self.grid.around_position(position);
        let texels = corners.map(|(index, weight)| self.texels[index][face] * weight);
        texels.sum()
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
        let mut sum = Vec4::ZERO;
        for (index, mut weight) in self.grid.around_position(receiver) {
            // Within the plane of the surface, as far as the centre of the voxel.
            let offset = self.grid.voxel(index).as_vec3() + 0.5 - origin;
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

    /// Returns about the mean radiance that the GGX lobe of a surface sees, in cd/m².
    ///
    /// The wider the lobe, the more it is that of the whole hemisphere; else irradiances of planes that face the mirror's
    /// direction, at three distances along it, are mixed in up to the first surface. That of the hemisphere is without the
    /// light from beyond [`dividers`](super::dividers::dividers). `position` is in metres; `normal` and `to_viewer` are unit
    /// vectors, and `roughness` is perceptual, 0.3 to 1.
    pub fn specular_radiance(
        &self,
        dividers: &[Vec3],
        position: Vec3,
        normal: Vec3,
        to_viewer: Vec3,
        roughness: f32,
    ) -> Vec3 {
        let direction = 2.0 * normal.dot(to_viewer) * normal - to_viewer;
        let receiver = self.grid.to_grid(position);
        let mut radiance = self.divided_irradiance(dividers, position, normal, to_viewer) / PI;
        // The weight of what no surface hides so far.
        let mut left = 1.0 - roughness * roughness;
        for distance in DISTANCES {
            let plane = self.facing_plane(receiver + direction * distance, direction);
            radiance += (plane.truncate() / PI - radiance * plane.w) * left;
            left *= plane.w * plane.w;
        }
        radiance
    }

    /// Irradiance of a plane that faces a direction times its visibility, and its visibility: in front of surfaces are
    /// voxels without one. More weight is that of a surface seen from behind, so the plane is behind it, and less is inside
    /// of a solid.
    fn facing_plane(&self, at: Vec3, direction: Vec3) -> Vec4 {
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            let texel = self.sample(at, 2 * axis + usize::from(direction[axis] < 0.0));
            let visible = 1.0 / (texel.w / EMPTY_WEIGHT).max(1.0);
            sum += texel * ((visible * direction[axis]).powi(2) / EMPTY_WEIGHT);
        }
        sum
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

//! Sharing of light between neighbouring surfaces of one plane.
//!
//! Neighbours count in pairs, one on each side: the mean of a pair is the light in the middle wherever light
//! changes evenly, as it does beside a wall, so sharing smooths noise and keeps gradients.

use super::{
    each,
    surface::{CLEARANCE, Surface, is_clear, main_face},
    voxels::{SUB_VOXELS, Voxels},
};
use glam::{IVec3, Vec3, Vec4};
use std::collections::HashMap;

/// Least cosine between the normals of surfaces that share.
const MIN_COSINE: f32 = 0.99;
/// Greatest distance between their planes, in voxels.
const MAX_STEP: f32 = 0.2;
/// A surface shares with those whose weight is at least this fraction of its own, and its own of theirs: in a pair of
/// unlike weights one would count alone.
const MIN_WEIGHT: f32 = 0.5;

/// Where a surface has a lower weight, most of its rays start inside something that touches it, and what the others
/// see is too dark: the lower the weight, the more its light is that of the surfaces around.
const TRUSTED_WEIGHT: f32 = 0.5;
/// At and below this weight all rays start inside: the surfaces around may be on the other side of a wall.
const BURIED_WEIGHT: f32 = 1.0 / 128.0;

/// The pairs of neighbours in a plane, as the steps to one of the two along the plane's axes, with the weight of each
/// neighbour. With [`OWN_WEIGHT`] these weights even out a checkerboard. Higher ones of the farthest blur the edges of
/// shadows, lower ones leave blotches.
const PAIRS: [([i32; 2], f32); 6] = [
    ([1, 0], 26.0),
    ([0, 1], 26.0),
    ([1, 1], 14.0),
    ([1, -1], 14.0),
    ([2, 0], 5.0),
    ([0, 2], 5.0),
];
/// The weight of the surface itself.
const OWN_WEIGHT: f32 = 28.0;

/// The surfaces and what they share.
struct Planes<'a> {
    voxels: &'a Voxels,
    surfaces: &'a [Surface],
    /// Per surface: light times weight, and weight.
    light: &'a [Vec4],
    /// Index of the surface that represents a face of a voxel.
    by_face: HashMap<(usize, usize), usize>,
}

/// Returns the light of each surface after sharing, from light times weight, and weight, of each.
pub fn shared_light(voxels: &Voxels, surfaces: &[Surface], light: &[Vec4]) -> Vec<Vec4> {
    let faces = |(i, surface): (usize, &Surface)| {
        let voxel = surface.voxel;
        let faces: Vec<_> = surface.faces().collect();
        faces.into_iter().map(move |face| ((voxel, face), i))
    };
    let by_face = surfaces.iter().enumerate().flat_map(faces).collect();
    let planes = Planes {
        voxels,
        surfaces,
        light,
        by_face,
    };
    each(surfaces.len(), |i| planes.shared(i))
}

impl Planes<'_> {
    fn shared(&self, i: usize) -> Vec4 {
        let own = self.light[i];
        let axis = main_face(self.surfaces[i].normal) / 2;
        let (mut sum, mut total) = (own * OWN_WEIGHT, OWN_WEIGHT);
        for ([u, v], weight) in PAIRS {
            let step = IVec3::AXES[(axis + 1) % 3] * u + IVec3::AXES[(axis + 2) % 3] * v;
            let pair = [-step, step].map(|step| self.coplanar_light(i, step));
            let (least, most) = (pair[0].w.min(pair[1].w), pair[0].w.max(pair[1].w));
            let are_alike = least >= (MIN_WEIGHT * own.w).max(1e-6) && MIN_WEIGHT * most <= own.w;
            if are_alike && self.is_open(i, step) {
                sum += (pair[0] + pair[1]) * weight;
                total += 2.0 * weight;
            }
        }
        let shared = sum / total;
        if own.w <= BURIED_WEIGHT || own.w >= TRUSTED_WEIGHT {
            return shared;
        }
        let around = self.light_around(i);
        if around.w > 0.0 {
            (around * (own.w / around.w)).lerp(shared, own.w / TRUSTED_WEIGHT)
        } else {
            shared
        }
    }

    /// The light of the same face in the voxels around, in pairs: what is on one side only may be beyond a wall.
    fn light_around(&self, i: usize) -> Vec4 {
        let surface = &self.surfaces[i];
        let (grid, face) = (self.voxels.grid, main_face(surface.normal));
        let light = |step: IVec3| {
            let voxel = grid.index(grid.voxel(surface.voxel) + step)?;
            let other = *self.by_face.get(&(voxel, face))?;
            Some(self.light[other]).filter(|light| light.w > 0.0)
        };
        let pairs = IVec3::AXES.into_iter().filter_map(|step| {
            let (before, after) = (light(-step)?, light(step)?);
            Some((before / before.w + after / after.w) * before.w.min(after.w))
        });
        pairs.sum()
    }

    /// The light of the surface that continues the plane of surface `i` in the column at `step`, 0 if there is
    /// none.
    fn coplanar_light(&self, i: usize, step: IVec3) -> Vec4 {
        let surface = &self.surfaces[i];
        let (normal, height) = (surface.normal, surface.height);
        let face = main_face(normal);
        let mut offset = step;
        let rise = (height - normal.dot(step.as_vec3())) / normal[face / 2];
        offset[face / 2] = (rise + 0.5).floor() as i32;
        let grid = self.voxels.grid;
        let found = grid
            .index(grid.voxel(surface.voxel) + offset)
            .and_then(|voxel| self.by_face.get(&(voxel, face)));
        let Some(&j) = found else {
            return Vec4::ZERO;
        };
        let other = &self.surfaces[j];
        let its_height = normal.dot(offset.as_vec3()) + other.height;
        let is_coplanar =
            normal.dot(other.normal) >= MIN_COSINE && (its_height - height).abs() <= MAX_STEP;
        if is_coplanar {
            self.light[j]
        } else {
            Vec4::ZERO
        }
    }

    /// Whether nothing stands on the plane of surface `i` between the far sides of both neighbours at `step`.
    fn is_open(&self, i: usize, step: IVec3) -> bool {
        let surface = &self.surfaces[i];
        let normal = surface.normal;
        // In front of all sub-voxels that the plane crosses.
        let thickness = normal.abs().element_sum() / SUB_VOXELS as f32;
        let lift = surface.height + thickness + CLEARANCE;
        let origin = self.voxels.grid.voxel(surface.voxel).as_vec3() + 0.5 + normal * lift;
        let beyond = 1.0 + 0.5 / step.abs().max_element() as f32;
        let step = step.as_vec3();
        let along: Vec3 = beyond * (step - normal * normal.dot(step));
        is_clear(self.voxels, origin - along, origin + along)
    }
}

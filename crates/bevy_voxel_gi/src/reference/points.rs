//! Stochastic voxelisation: random points on triangles (thesis 6.4.3; G. Turk, *Generating Random Points in
//! Triangles*, 1990).
//!
//! A voxel with a point has those sub-voxels that the triangle's plane crosses within its bounds. Whole voxels, as in
//! the thesis, would bring surfaces forward by half a voxel on average; the sub-voxels with a point alone would let light
//! through. What a camera sees can be added, pixel by pixel.

use super::{
    clip::Part,
    grid::{FACES, VolumeGrid},
    overlap::{SINK, TriangleOverlap},
    packed_surface::MIN_FACE_COSINE,
    voxels::{SUB_VOXELS, SurfacePart, Triangle, Voxels},
};
use glam::{IVec3, UVec3, Vec2, Vec3};

/// The sub-voxels that a pixel marks are at most this many away from its own along each axis: farther ones would
/// thicken edges, and without them surfaces under grazing angles would have holes.
const REACH: i32 = 1;

/// The area of what a pixel marks, in units of a voxel's face: it decides where there is no triangle only.
const VISIBLE_AREA: f32 = 1e-12;

/// Two random numbers from 0 to below 1 (M. Jarzynski and M. Olano, *Hash Functions for GPU Rendering*, 2020: pcg3d).
fn random(key: UVec3) -> Vec2 {
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [mut x, mut y, mut z] = key.to_array().map(step);
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    [x, y, z] = [x, y, z].map(|v| v ^ (v >> 16));
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    Vec2::new((x >> 8) as f32, (y >> 8) as f32) / 16_777_216.0
}

impl Voxels {
    /// Voxelises triangles by this number of random points on each, of which each stands for an equal part of the area;
    /// those without an area or that are not finite are skipped.
    pub fn from_points(grid: VolumeGrid, triangles: &[Triangle], points: u32) -> Self {
        let mut voxels = Self::empty(grid);
        let mut parts = Vec::new();
        for (number, triangle) in (0..).zip(triangles) {
            let [a, b, c] = triangle.corners.map(|corner| grid.to_grid(corner));
            let Some(overlap) = TriangleOverlap::new([a, b, c]) else {
                continue;
            };
            let area = 0.5 * (b - a).cross(c - a).length() / points as f32;
            for i in 0..points {
                let r = random(UVec3::new(0, number, i));
                let root = r.x.sqrt();
                let point = a * (1.0 - root) + b * ((1.0 - r.y) * root) + c * (r.y * root);
                let voxel = (point - overlap.normal * SINK).floor().as_ivec3();
                if voxels.mark_in(voxel, |min, size| overlap.crosses_plane(min, size)) {
                    let axis = overlap.main_axis();
                    let from_corner = point - overlap.normal * SINK - voxel.as_vec3();
                    let part = Part {
                        area,
                        centroid: Vec2::new(
                            from_corner[(axis + 1) % 3],
                            from_corner[(axis + 2) % 3],
                        ),
                        size: Vec2::splat((area * overlap.normal[axis].abs()).sqrt()),
                    };
                    parts.push(SurfacePart::new(voxel, &overlap, triangle, part));
                }
            }
        }
        for part in &parts {
            voxels.add_part(part);
        }
        voxels
    }

    /// Marks what a camera sees at a pixel: the sub-voxels around the position that its plane crosses, and the faces that
    /// the normal turns to, unless they have a surface of a triangle. `position` is in metres.
    pub fn mark_visible(&mut self, position: Vec3, normal: Vec3, material: u32) {
        let point = self.grid.to_grid(position) - normal * SINK;
        let voxel = point.floor();
        let Some(index) = self.grid.index(voxel.as_ivec3()) else {
            return;
        };
        let local = (point - voxel) * SUB_VOXELS as f32;
        let own = local.floor().as_ivec3();
        let reach = 0.5 * normal.abs().element_sum();
        for bit in 0..64 {
            let sub = IVec3::new(bit % 4, bit / 4 % 4, bit / 16);
            let is_near = (sub - own).abs().max_element() <= REACH;
            if is_near && normal.dot(sub.as_vec3() + 0.5 - local).abs() <= reach {
                self.masks[index] |= 1 << bit;
            }
        }
        for (face, direction) in FACES.into_iter().enumerate() {
            let cosine = normal.dot(direction);
            if cosine > MIN_FACE_COSINE {
                let plane = (normal, normal.dot(point - voxel - 0.5));
                self.add_face(index, face, [VISIBLE_AREA, 1.0], cosine, plane, material);
            }
        }
    }
}

//! Whether a triangle overlaps a box: the separating axes of a triangle and a cube, prepared once per
//! triangle (M. Schwarz and H.-P. Seidel, *Fast Parallel Surface and Solid Voxelization on GPUs*, 2010).
//!
//! The axes are the triangle's normal, the three of the grid, and the nine cross products of edges,
//! which are the edges' normals in the three projections along an axis.

use glam::{Vec2, Vec3};

/// Distance by which a triangle is moved against its normal before it is voxelised, and by which its
/// bounds shrink in its plane, in voxels.
///
/// A triangle exactly between two layers of cells is thereby in the one behind it, and one that ends
/// there overlaps one of them, whatever the rounding.
pub const SINK: f32 = 1.0 / 1024.0;

/// A triangle in grid coordinates, prepared for tests against many boxes.
#[derive(Clone, Copy, Debug)]
pub struct TriangleOverlap {
    /// Unit normal; the counter-clockwise side is the front.
    pub normal: Vec3,
    /// Its corners, moved against the normal by [`SINK`].
    pub corners: [Vec3; 3],
    /// Lowest corner of the triangle's bounds, shrunk slightly ([`SINK`]).
    pub min: Vec3,
    /// Highest corner of the triangle's bounds, likewise.
    pub max: Vec3,
    plane: f32,
    /// Per axis of projection and per edge: inward normal, and offset.
    edges: [[(Vec2, f32); 3]; 3],
}

/// Returns the two coordinates that remain when `axis` is projected away, in cyclic order.
fn project(v: Vec3, axis: usize) -> Vec2 {
    Vec2::new(v[(axis + 1) % 3], v[(axis + 2) % 3])
}

impl TriangleOverlap {
    /// Prepares a triangle; `None` if it has no area or is not finite.
    pub fn new(corners: [Vec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let scale = (b - a).abs().max((c - a).abs()).max_element();
        if !(scale > 0.0 && scale.is_finite() && corners.iter().all(|v| v.is_finite())) {
            return None;
        }
        let cross = ((b - a) / scale).cross((c - a) / scale);
        let length = cross.length();
        // Below this, the normal is rounding noise.
        if length < 1e-6 {
            return None;
        }
        let normal = cross / length;
        let corners = corners.map(|v| v - normal * SINK);
        let edges = [0, 1, 2].map(|axis| {
            let sign = if normal[axis] < 0.0 { -1.0 } else { 1.0 };
            [0, 1, 2].map(|i| {
                let from = project(corners[i], axis);
                let edge = project(corners[(i + 1) % 3], axis) - from;
                let inward = Vec2::new(-edge.y, edge.x) * sign;
                (inward, -inward.dot(from))
            })
        });
        let min = corners[0].min(corners[1]).min(corners[2]);
        let max = corners[0].max(corners[1]).max(corners[2]);
        let less = (0.25 * (max - min)).min(SINK * (1.0 - normal.abs()));
        Some(Self {
            normal,
            corners,
            min: min + less,
            max: max - less,
            plane: -normal.dot(corners[0]),
            edges,
        })
    }

    /// Returns the axis of the largest component of the normal; of equal ones the first.
    pub fn main_axis(&self) -> usize {
        let Vec3 { x, y, z } = self.normal.abs();
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        }
    }

    /// Returns whether the triangle overlaps the cube of edge `size` whose lowest corner is `min`.
    ///
    /// Contact at a bound alone does not count; a triangle in a grid plane is in the upper cell.
    pub fn overlaps(&self, min: Vec3, size: f32) -> bool {
        self.crosses_plane(min, size)
            && (0..3).all(|axis| {
                let corner = project(min, axis);
                self.edges[axis].iter().all(|(inward, offset)| {
                    let farthest = size * (inward.x.max(0.0) + inward.y.max(0.0));
                    inward.dot(corner) + offset + farthest >= 0.0
                })
            })
    }

    /// Returns whether the triangle's plane crosses a cube that overlaps the triangle's bounds.
    pub fn crosses_plane(&self, min: Vec3, size: f32) -> bool {
        for axis in 0..3 {
            let (low, high) = (min[axis], min[axis] + size);
            let flat = self.min[axis] == self.max[axis];
            if self.min[axis] >= high || self.max[axis] < low || (!flat && self.max[axis] == low) {
                return false;
            }
        }
        let distance = self.normal.dot(min + 0.5 * size) + self.plane;
        let reach = 0.5 * size * self.normal.abs().element_sum();
        distance.abs() <= reach
    }
}

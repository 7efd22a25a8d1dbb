//! A triangle and a box: whether they overlap, and the part of the triangle that is inside.
//!
//! The former is tested by the separating axes of a triangle and a cube, prepared once per triangle (M. Schwarz and
//! H.-P. Seidel, *Fast Parallel Surface and Solid Voxelization on GPUs*, 2010): the triangle's normal, the three of the
//! grid, and the nine cross products of edges, which are the edges' normals in the three projections along an axis. For
//! the latter the triangle is clipped to one half-space after another (I. Sutherland and G. Hodgman, *Reentrant Polygon
//! Clipping*, 1974).

use glam::{DVec2, DVec3, Vec2, Vec3};

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
        self.normal.abs().max_position()
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

/// The largest area of a plane in a voxel, sqrt(2): through two opposite edges.
const LARGEST_AREA: f64 = std::f64::consts::SQRT_2;

/// The part of a triangle inside of a voxel; coordinates are from the voxel's lowest corner, projected along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Area in units of a voxel's face, not projected.
    pub area: f32,
    /// Centre of the projected area.
    pub centroid: Vec2,
    /// Edges of its bounds.
    pub size: Vec2,
}

/// Returns the part of a triangle inside of the voxel whose lowest corner is `min`, in grid coordinates.
pub fn part_in_voxel(corners: [Vec3; 3], min: Vec3, axis: usize) -> Part {
    let corners = corners.map(|corner| corner.as_dvec3() - min.as_dvec3());
    let mut polygon = corners.to_vec();
    for axis in DVec3::AXES {
        polygon = in_front(&polygon, |p| axis.dot(p));
        polygon = in_front(&polygon, |p| 1.0 - axis.dot(p));
    }
    let projected = |p: &DVec3| DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    let is_empty = polygon.is_empty();
    let points = if is_empty { &corners[..] } else { &polygon };
    let points: Vec<_> = points.iter().map(projected).collect();
    let bound = |of: fn(DVec2, DVec2) -> DVec2| points.iter().copied().reduce(of);
    let low = bound(DVec2::min).unwrap_or_default();
    let high = bound(DVec2::max).unwrap_or_default();
    let (mut doubled, mut moment) = (0.0, DVec2::ZERO);
    for pair in points.windows(2) {
        let [u, v] = [pair[0] - points[0], pair[1] - points[0]];
        doubled += u.perp_dot(v);
        moment += u.perp_dot(v) * (u + v);
    }
    let middle = 0.5 * (low + high);
    let (centroid, size) = if is_empty {
        (middle.clamp(DVec2::ZERO, DVec2::ONE), DVec2::ZERO)
    } else if doubled.abs() > 1e-10 {
        let centroid = points[0] + moment / (3.0 * doubled);
        (centroid.clamp(low, high), high - low)
    } else {
        (middle, high - low)
    };
    Part {
        // Finite even for triangles so large that rounding moves the cuts.
        area: area(&polygon).min(LARGEST_AREA) as f32,
        centroid: centroid.as_vec2(),
        size: size.as_vec2(),
    }
}

/// The part of a convex polygon where `height`, which is linear, is not negative.
fn in_front(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut part = vec![];
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let (low, high) = (height(from), height(to));
        if low >= 0.0 {
            part.push(from);
        }
        if (low >= 0.0) != (high >= 0.0) {
            part.push(from.lerp(to, low / (low - high)));
        }
    }
    part
}

/// The area of a convex planar polygon.
fn area(polygon: &[DVec3]) -> f64 {
    let triangles = polygon.windows(2).skip(1);
    let doubled: DVec3 = triangles
        .map(|pair| (pair[0] - polygon[0]).cross(pair[1] - polygon[0]))
        .sum();
    0.5 * doubled.length()
}

//! The part of a triangle inside of a voxel: the triangle is clipped to one half-space after another
//! (I. Sutherland and G. Hodgman, *Reentrant Polygon Clipping*, 1974).

use glam::{DVec2, DVec3, Vec2, Vec3};

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
    let low = points
        .iter()
        .copied()
        .reduce(DVec2::min)
        .unwrap_or_default();
    let high = points
        .iter()
        .copied()
        .reduce(DVec2::max)
        .unwrap_or_default();
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

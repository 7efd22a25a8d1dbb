//! The area of a triangle's part inside of a voxel: the triangle is clipped to one half-space after another
//! (I. Sutherland and G. Hodgman, *Reentrant Polygon Clipping*, 1974).

use glam::{DVec3, Vec3};

/// The largest area of a plane in a voxel, sqrt(2): through two opposite edges.
const LARGEST_AREA: f64 = std::f64::consts::SQRT_2;

/// Returns the area of a triangle's part inside of the voxel whose lowest corner is `min`, in grid coordinates: in
/// units of a voxel's face.
pub fn area_in_voxel(corners: [Vec3; 3], min: Vec3) -> f32 {
    let mut polygon = corners
        .map(|corner| corner.as_dvec3() - min.as_dvec3())
        .to_vec();
    for axis in DVec3::AXES {
        polygon = in_front(&polygon, |p| axis.dot(p));
        polygon = in_front(&polygon, |p| 1.0 - axis.dot(p));
    }
    // Finite even for triangles so large that rounding moves the cuts.
    area(&polygon).min(LARGEST_AREA) as f32
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

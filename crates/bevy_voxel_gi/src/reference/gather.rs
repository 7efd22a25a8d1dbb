//! What arrives at a surface or in the middle of a voxel, by rays.

use super::{
    grid::FACES,
    rays::{cosine_ray, hash_unit, sphere_ray},
    surface::Surface,
};
use glam::{Vec3, Vec4};

/// Sets of rays that take turns, a frame each: together they are one dense set.
pub const RAY_SETS: u32 = 8;

/// Points of a surface from which rays begin in a frame.
pub const FRAME_POINTS: u32 = 4;

/// From point to point, so that neighbours are not in the same frame; coprime to 16.
pub const POINT_STEP: u32 = 5;

fn turn(voxel: usize, salt: u32, frame: u32) -> f32 {
    let series = (frame / RAY_SETS).wrapping_mul(0x9e37_79b9);
    hash_unit(
        (voxel as u32)
            .wrapping_mul(64)
            .wrapping_add(salt)
            .wrapping_add(series),
    )
}

/// The mean over rays about a surface's normal, more where the cosine is larger, times the share of
/// rays that count; and that share.
///
/// `arriving` gives what comes along a ray from an origin in grid coordinates, None where a ray sees
/// the back of a surface. A point more than a quarter of whose rays do is inside something, and none
/// of its rays counts. `rays` is a multiple of [`FRAME_POINTS`]. With `one_side` rays begin only from
/// the points that the middle one sees.
pub fn hemisphere(
    surface: &Surface,
    rays: u32,
    one_side: bool,
    frame: u32,
    arriving: impl Fn(Vec3, Vec3) -> Option<Vec3>,
) -> Vec4 {
    let turn = turn(surface.voxel, u32::from(surface.faces), frame);
    let mut sum = Vec4::ZERO;
    for k in 0..FRAME_POINTS {
        let step = frame.wrapping_mul(FRAME_POINTS).wrapping_add(k);
        let number = step.wrapping_mul(POINT_STEP) as usize;
        let point = if one_side {
            surface.one_side[number % surface.one_side.len()]
        } else {
            number % surface.points.len()
        };
        let origin = surface.origin(point);
        let (mut of_point, mut all) = (Vec4::ZERO, 0.0);
        for i in (k..rays).step_by(FRAME_POINTS as usize) {
            let place = i * RAY_SETS + frame % RAY_SETS;
            let direction = cosine_ray(place, rays * RAY_SETS, turn, surface.normal);
            all += 1.0;
            if let Some(value) = arriving(origin, direction) {
                of_point += value.extend(1.0);
            }
        }
        if of_point.w >= 0.75 * all {
            sum += of_point;
        }
    }
    sum / rays.max(1) as f32
}

/// The same in the middle of a voxel without surfaces, for its six faces.
///
/// All weights are `weight`, or 0 where more than a quarter of the rays see backs: inside something.
pub fn sphere(
    voxel: usize,
    center: Vec3,
    rays: u32,
    frame: u32,
    weight: f32,
    arriving: impl Fn(Vec3, Vec3) -> Option<Vec3>,
) -> [Vec4; 6] {
    let turn = turn(voxel, 0, frame);
    let mut sums = [Vec4::ZERO; 6];
    let mut valid = 0;
    for i in 0..rays {
        let place = i * RAY_SETS + frame % RAY_SETS;
        let direction = sphere_ray(place, rays * RAY_SETS, turn);
        if let Some(value) = arriving(center, direction) {
            valid += 1;
            for (sum, face) in sums.iter_mut().zip(FACES) {
                // The cosine as weight, so that a uniform field is uniform however few rays there are.
                *sum += value.extend(1.0) * direction.dot(face).max(0.0);
            }
        }
    }
    if valid == 0 || 4 * valid < 3 * rays {
        return [Vec4::ZERO; 6];
    }
    sums.map(|sum| (sum / sum.w.max(1e-6)) * weight)
}

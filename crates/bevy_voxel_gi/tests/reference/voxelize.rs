//! Tests of voxelisation, packed surfaces and ray tracing.

use crate::support::shapes::{room, solid, unit_grid};
use bevy_voxel_gi::reference::{
    Triangle, Voxels,
    overlap::{SINK, TriangleOverlap},
    packed_surface::{Plane, pack_normal, pack_surface, unpack_normal},
    rays::hash_unit,
    surface::surfaces,
    trace::trace,
    voxels::SUB_VOXELS,
};
use glam::{DVec3, IVec3, Quat, Vec3};
use proptest::prelude::*;

fn vector(range: std::ops::Range<f32>) -> impl Strategy<Value = Vec3> {
    [range.clone(), range.clone(), range].prop_map(Vec3::from_array)
}

/// Whether a part of a triangle remains when it is clipped to a box.
fn clipped(corners: [DVec3; 3], min: DVec3, max: DVec3) -> bool {
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        for (sign, border) in [(1.0, min[axis]), (-1.0, -max[axis])] {
            let height = |p: DVec3| sign * p[axis] - border;
            let mut left = vec![];
            for i in 0..polygon.len() {
                let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                let (ha, hb) = (height(a), height(b));
                if ha >= 0.0 {
                    left.push(a);
                }
                if (ha >= 0.0) != (hb >= 0.0) {
                    left.push(a.lerp(b, ha / (ha - hb)));
                }
            }
            polygon = left;
        }
    }
    !polygon.is_empty()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5_000))]

    #[test]
    fn overlap_is_what_clipping_says(
        a in vector(-2.0..3.0), b in vector(-2.0..3.0), c in vector(-2.0..3.0),
    ) {
        let Some(overlap) = TriangleOverlap::new([a, b, c]) else { return Ok(()) };
        let corners = [a, b, c].map(|v| (v - overlap.normal * SINK).as_dvec3());
        let overlaps = overlap.overlaps(Vec3::ZERO, 1.0);
        const MARGIN: f64 = 1e-4;
        if overlaps {
            prop_assert!(clipped(corners, DVec3::splat(-MARGIN), DVec3::splat(1.0 + MARGIN)));
        } else {
            // The bounds shrink by the same distance by which triangles are moved.
            let margin = MARGIN + f64::from(SINK);
            prop_assert!(!clipped(corners, DVec3::splat(margin), DVec3::splat(1.0 - margin)));
        }
    }

    /// The largest error over 2,000,000 directions is 3.90 degrees.
    #[test]
    fn keys_keep_the_plane(n in vector(-1.0..1.0), height in -0.866f32..0.866) {
        prop_assume!(n.length() > 0.1);
        let n = n.normalize();
        prop_assert!(unpack_normal(pack_normal(n)).angle_between(n) < 3.95f32.to_radians());
        let plane = Plane::new(pack_surface(0.3, 1.0, n, height));
        prop_assert_eq!(plane.normal, unpack_normal(pack_normal(n)));
        prop_assert!((plane.height - height).abs() < 1.0 / 1024.0, "{}", plane.height);
    }

    /// No ray passes through a surface, and none ends before there is one.
    #[test]
    fn rays_end_where_they_meet_a_surface(
        corners in [vector(-1.0..9.0), vector(-1.0..9.0), vector(-1.0..9.0)],
        origin in vector(0.1..7.9),
        direction in vector(-1.0..1.0),
    ) {
        prop_assume!(direction.length() > 0.1);
        let direction = direction.normalize();
        let voxels = Voxels::new(unit_grid(8), &[sheet(corners)]);
        prop_assert!(!goes_through(&voxels, &[sheet(corners)], origin, direction));
        if let Some(hit) = trace(&voxels, origin, direction, f32::INFINITY) {
            prop_assert!(voxels.is_occupied(hit.sub_voxel));
            prop_assert!(trace(&voxels, origin, direction, 0.5 * hit.distance).is_none());
        }
        // The same with one side, unless the ray starts at the surface, where it may be in front of it.
        let scene = [Triangle { double_sided: false, ..sheet(corners) }];
        let voxels = Voxels::new(unit_grid(8), &scene);
        if !voxels.is_occupied((origin * SUB_VOXELS as f32).floor().as_ivec3()) {
            prop_assert!(!goes_through(&voxels, &scene, origin, direction));
        }
    }
}

/// Where surfaces cross, a voxel stores only one of them for each of its faces, and a ray may pass
/// through the other.
#[test]
fn hardly_a_ray_slips_through_where_surfaces_cross() {
    let mut number = 0u32;
    let mut random = || {
        number += 1;
        hash_unit(number)
    };
    let mut place = |low: f32, high: f32| {
        low + (high - low) * Vec3::from_array(std::array::from_fn(|_| random()))
    };
    let mut through = 0;
    for _ in 0..1_000 {
        let scene = [0; 3].map(|_| sheet([0; 3].map(|_| place(-1.0, 9.0))));
        let voxels = Voxels::new(unit_grid(8), &scene);
        for _ in 0..100 {
            let direction = place(-1.0, 1.0).normalize_or(Vec3::X);
            through += u32::from(goes_through(&voxels, &scene, place(0.1, 7.9), direction));
        }
    }
    println!("{through} of 100,000");
    assert!(through < 10, "{through}");
}

/// Hardly a ray leaves a closed room whose walls lie on borders of sub-voxels but for a small turn.
#[test]
fn hardly_a_ray_leaves_a_room_that_is_turned_a_little() {
    let random = |i: u32| Vec3::from_array([0, 1, 2].map(|c| 2.0 * hash_unit(3 * i + c) - 1.0));
    for degrees in [0.005f32, 0.02, 0.1, 0.3, 1.0, 1.5, 2.0, 2.4] {
        let mut left = 0;
        for number in 0..20 {
            let axis = random(number).normalize();
            let turn = Quat::from_axis_angle(axis, degrees.to_radians());
            let turned = |v: Vec3| Vec3::splat(4.0) + turn * (v - 4.0);
            let mut walls = room(Vec3::splat(1.25), Vec3::splat(6.75));
            for triangle in &mut walls {
                triangle.corners = triangle.corners.map(turned);
            }
            let voxels = Voxels::new(unit_grid(8), &walls);
            for ray in 0..5_000 {
                let origin = 4.0 + 2.0 * random(1_000 + 2 * ray);
                let direction = random(1_001 + 2 * ray).normalize();
                left += u32::from(trace(&voxels, origin, direction, f32::INFINITY).is_none());
            }
        }
        println!("{degrees} degrees: {left} of 100,000");
        assert!(left < 10, "{left} at {degrees} degrees");
    }
}

fn sheet(corners: [Vec3; 3]) -> Triangle {
    Triangle {
        corners,
        material: 0,
        double_sided: true,
    }
}

/// Whether a ray passes through one of these surfaces, well within the surface and the volume.
fn goes_through(voxels: &Voxels, scene: &[Triangle], origin: Vec3, direction: Vec3) -> bool {
    let hit = trace(voxels, origin, direction, f32::INFINITY);
    let end = hit.map_or(f32::INFINITY, |h| h.distance);
    scene.iter().any(|triangle| {
        last_crossing(triangle.corners, origin, direction).is_some_and(|distance| {
            let place = origin + direction * distance;
            place.min_element() > 0.0 && place.max_element() < 8.0 && end > distance
        })
    })
}

const SUB_VOXEL_DIAGONAL: f32 = 0.4331;

/// Where a ray is a sub-voxel behind a triangle that it hits; `None` if that is not well within the
/// triangle's border.
fn last_crossing([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f32> {
    let normal = (b - a).cross(c - a).try_normalize()?;
    let distance = normal.dot(a - origin) / normal.dot(direction);
    let beyond = SUB_VOXEL_DIAGONAL / normal.dot(direction).abs();
    let place = origin + direction * distance;
    let within = [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
        let inward = normal.cross(to - from).normalize_or_zero();
        inward.dot(place - from) > beyond
    });
    (distance > 0.0 && within).then_some(distance + beyond)
}

#[test]
fn axes_are_exact() {
    for n in bevy_voxel_gi::reference::FACES {
        assert_eq!(unpack_normal(pack_normal(n)), n);
    }
}

/// A surface on a border between voxels is in one layer, whatever the rounding.
#[test]
fn what_lies_on_a_border_is_in_one_layer() {
    for rounding in [-1e-5, 0.0, 1e-5] {
        let [low, high] = [2.0 - rounding, 6.0 + rounding].map(Vec3::splat);
        let voxels = Voxels::new(unit_grid(8), &solid(low, high));
        for place in 0..32 * 32 * 32 {
            let at = IVec3::new(place % 32, place / 32 % 32, place / (32 * 32));
            let inside = at.cmpge(IVec3::splat(8)).all() && at.cmplt(IVec3::splat(24)).all();
            let deeper = at.cmpge(IVec3::splat(9)).all() && at.cmplt(IVec3::splat(23)).all();
            assert_eq!(voxels.is_occupied(at), inside && !deeper, "{at} {rounding}");
        }
    }
}

#[test]
fn thin_walls_have_two_sides() {
    for thickness in [0.01, 0.2, 0.5, 0.9] {
        let low = Vec3::new(-1.0, 3.05, -1.0);
        let high = Vec3::new(9.0, 3.05 + thickness, 9.0);
        let voxels = Voxels::new(unit_grid(8), &solid(low, high));
        let all = surfaces(&voxels, false);
        for (normal, count) in [(Vec3::Y, 64), (Vec3::NEG_Y, 64)] {
            let sides: Vec<_> = all.iter().filter(|s| s.normal == normal).collect();
            assert_eq!(sides.len(), count, "thickness {thickness}");
            for side in sides {
                assert_eq!(side.points.len(), 16);
                for point in 0..16 {
                    let end = trace(&voxels, side.origin(point), normal, f32::INFINITY);
                    assert_eq!(end, None, "a ray meets its own surface");
                }
            }
        }
    }
}

#[test]
fn tilted_surfaces_do_not_meet_themselves() {
    for normal in [
        Vec3::new(0.3, 0.9, 0.1),
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(0.1, -0.2, 0.9),
    ] {
        let normal = normal.normalize();
        let (t, b) = normal.any_orthonormal_pair();
        let at = |x: f32, y: f32| Vec3::splat(4.0) + 20.0 * (x * t + y * b);
        let mut corners = [at(-1.0, -1.0), at(1.0, -1.0), at(0.0, 1.5)];
        if (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .dot(normal)
            < 0.0
        {
            corners.swap(0, 1);
        }
        let sheet = Triangle {
            corners,
            material: 0,
            double_sided: true,
        };
        let voxels = Voxels::new(unit_grid(8), &[sheet]);
        let (mut rays, mut hits) = (0, 0);
        for surface in surfaces(&voxels, false) {
            for point in 0..surface.points.len() {
                rays += 1;
                let origin = surface.origin(point);
                hits +=
                    usize::from(trace(&voxels, origin, surface.normal, f32::INFINITY).is_some());
            }
        }
        assert!(rays > 500);
        assert_eq!(hits, 0, "of {rays} rays about {normal}");
    }
}

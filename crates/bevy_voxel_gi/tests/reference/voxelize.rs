//! Tests of voxelisation, packed surfaces and ray tracing; of the areas of triangles in voxels, and of materials that share
//! a face.

use crate::support::{one_sided, quad, room, solid, unit_grid};
use bevy_voxel_gi::reference::{
    FACES, Material, Triangle, Voxels,
    overlap::{SINK, TriangleOverlap, part_in_voxel},
    packed_surface::{Plane, pack_normal, pack_surface, unpack_normal},
    rays::hash_unit,
    surface::surfaces,
    trace::trace,
    voxels::{MIN_AREA, SUB_VOXELS},
};
use glam::{DVec3, IVec3, Quat, Vec3};
use proptest::prelude::*;
use std::f32::consts::SQRT_2;

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
    for n in FACES {
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
        let voxels = Voxels::new(unit_grid(8), &[sheet(corners)]);
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

const EDGE: u32 = 6;

fn area([a, b, c]: [Vec3; 3]) -> f32 {
    0.5 * (b - a).cross(c - a).length()
}

fn perimeter([a, b, c]: [Vec3; 3]) -> f32 {
    a.distance(b) + b.distance(c) + c.distance(a)
}

fn voxel_corners() -> impl Iterator<Item = Vec3> {
    let grid = unit_grid(EDGE);
    (0..grid.len()).map(move |index| grid.voxel(index).as_vec3())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// The parts of a triangle sum up to it, and none is larger than a plane's largest part in a voxel.
    #[test]
    fn the_parts_sum_up_to_the_triangle(a in vector(0.1..5.9), b in vector(0.1..5.9), c in vector(0.1..5.9)) {
        let corners = [a, b, c];
        let parts: Vec<_> = voxel_corners().map(|voxel| part_in_voxel(corners, voxel, 0).area).collect();
        prop_assert!(parts.iter().all(|part| (0.0..=SQRT_2 + 1e-6).contains(part)));
        let (sum, whole) = (parts.iter().sum::<f32>(), area(corners));
        prop_assert!((sum - whole).abs() <= 1e-3 * whole, "{sum} of {whole}");
    }

    /// In the voxels, too, up to the strip at the border of the bounds that does not count as overlap. A face in front
    /// of a surface has its projected area.
    #[test]
    fn the_areas_of_a_face_sum_up(a in vector(0.1..5.9), b in vector(0.1..5.9), c in vector(0.1..5.9)) {
        let corners = [a, b, c];
        let Some(overlap) = TriangleOverlap::new(corners) else { return Ok(()) };
        let triangle = Triangle { corners, material: 3, double_sided: true };
        let voxels = Voxels::new(unit_grid(EDGE), &[triangle]);
        let touched = voxels.masks.iter().filter(|mask| **mask != 0).count() as f32;
        for (face, direction) in FACES.into_iter().enumerate() {
            let cosine = overlap.normal.dot(direction).abs();
            let parts = || voxels.material_areas.iter().flat_map(|faces| &faces[face]);
            prop_assert!(parts().all(|part| part.material == 3));
            if cosine < 0.13 {
                continue;
            }
            let (sum, whole) = (parts().map(|part| part.area).sum::<f32>(), area(corners) * cosine);
            let allowed = 1e-3 * whole + SINK * perimeter(corners) + MIN_AREA * touched;
            prop_assert!((sum - whole).abs() <= allowed, "{sum} of {whole}");
        }
    }
}

/// Random points on triangles are in a voxel as often as its part of the area.
#[test]
fn areas_are_what_random_points_say() {
    const POINTS: u32 = 40_000;
    let mut number = 0;
    let mut random = || {
        number += 1;
        hash_unit(number)
    };
    for _ in 0..20 {
        let corners = [0; 3].map(|_| Vec3::from_array([0; 3].map(|_| -1.0 + 3.0 * random())));
        let [a, b, c] = corners;
        let inside = (0..POINTS).filter(|_| {
            let (root, v) = (random().sqrt(), random());
            let point = a * (1.0 - root) + b * ((1.0 - v) * root) + c * (v * root);
            point.floor().as_ivec3() == IVec3::ZERO
        });
        let wanted = inside.count() as f32 / POINTS as f32;
        let found = part_in_voxel(corners, Vec3::ZERO, 0).area / area(corners);
        // Five standard deviations.
        let allowed = 5.0 * (wanted * (1.0 - wanted) / POINTS as f32).sqrt() + 1e-4;
        assert!(
            (found - wanted).abs() < allowed,
            "{found} {wanted} {corners}",
            corners = a
        );
    }
}

/// Two strips of a floor, one to this x and one from there.
fn two_strips(border: f32) -> Vec<Triangle> {
    let strip = |low: f32, high: f32, material| {
        let at = |x: f32, z: f32| Vec3::new(x, 2.4, z);
        let corners = [at(low, -1.0), at(low, 9.0), at(high, 9.0), at(high, -1.0)];
        quad(corners, material)
    };
    [strip(-1.0, border, 0), strip(border, 9.0, 1)].concat()
}

/// Where two materials share a face, its material is their mean, by area.
#[test]
fn materials_of_a_face_mix_by_area() {
    let materials = [(Vec3::X, 2.0), (Vec3::Y, 0.0)].map(|(albedo, emission)| Material {
        albedo,
        emission: Vec3::splat(emission),
    });
    for share in [0.5, 0.25, 0.8] {
        let grid = unit_grid(8);
        let voxels = Voxels::new(grid, &two_strips(3.0 + share));
        let index = grid.index(IVec3::new(3, 2, 4)).expect("inside");
        let found = voxels.face_material(index, 2, &materials);
        let albedo = Vec3::new(share, 1.0 - share, 0.0);
        assert!(found.albedo.abs_diff_eq(albedo, 1e-4), "{}", found.albedo);
        let emission = Vec3::splat(2.0 * share);
        assert!(
            found.emission.abs_diff_eq(emission, 1e-3),
            "{}",
            found.emission
        );
        assert_eq!(
            voxels.face_material(index, 3, &materials),
            Material::default()
        );
    }
}

/// A picture hides the wall behind it, and counts as much.
#[test]
fn a_picture_on_a_wall_emits_all_of_its_light() {
    let materials = [(0.8, 0.0), (0.2, 5.0)].map(|(albedo, emission)| Material {
        albedo: Vec3::splat(albedo),
        emission: Vec3::splat(emission),
    });
    let layer = |y: f32, material| {
        let corners = [(-9.0, -9.0), (-9.0, 40.0), (40.0, -9.0)];
        one_sided(corners.map(|(x, z)| Vec3::new(x, y, z)), material)
    };
    let voxels = Voxels::new(unit_grid(8), &[layer(2.4, 0), layer(2.42, 1)]);
    let index = voxels.grid.index(IVec3::new(3, 2, 4)).expect("inside");
    let found = voxels.face_material(index, 2, &materials);
    assert!(
        found.albedo.abs_diff_eq(Vec3::splat(0.5), 1e-4),
        "{}",
        found.albedo
    );
    assert!(
        found.emission.abs_diff_eq(Vec3::splat(5.0), 1e-3),
        "{}",
        found.emission
    );
}

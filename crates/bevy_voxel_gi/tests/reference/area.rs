//! Tests of the areas of triangles in voxels, and of materials that share a face.

use crate::support::shapes::unit_grid;
use bevy_voxel_gi::reference::{
    FACES, Material, Triangle, Voxels,
    clip::part_in_voxel,
    overlap::{SINK, TriangleOverlap},
    rays::hash_unit,
    voxels::MIN_AREA,
};
use glam::{IVec3, Vec3};
use proptest::prelude::*;
use std::f32::consts::SQRT_2;

const EDGE: u32 = 6;

fn vector() -> impl Strategy<Value = Vec3> {
    [0.1f32..5.9, 0.1f32..5.9, 0.1f32..5.9].prop_map(Vec3::from_array)
}

fn area([a, b, c]: [Vec3; 3]) -> f32 {
    0.5 * (b - a).cross(c - a).length()
}

fn perimeter([a, b, c]: [Vec3; 3]) -> f32 {
    a.distance(b) + b.distance(c) + c.distance(a)
}

fn voxels() -> impl Iterator<Item = Vec3> {
    let grid = unit_grid(EDGE);
    (0..grid.len()).map(move |index| grid.voxel(index).as_vec3())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// The parts of a triangle sum up to it, and none is larger than a plane's largest part in a voxel.
    #[test]
    fn the_parts_sum_up_to_the_triangle(a in vector(), b in vector(), c in vector()) {
        let corners = [a, b, c];
        let parts: Vec<_> = voxels().map(|voxel| part_in_voxel(corners, voxel, 0).area).collect();
        prop_assert!(parts.iter().all(|part| (0.0..=SQRT_2 + 1e-6).contains(part)));
        let (sum, whole) = (parts.iter().sum::<f32>(), area(corners));
        prop_assert!((sum - whole).abs() <= 1e-3 * whole, "{sum} of {whole}");
    }

    /// In the voxels, too, up to the strip at the border of the bounds that does not count as overlap. A face in front
    /// of a surface has its projected area.
    #[test]
    fn the_areas_of_a_face_sum_up(a in vector(), b in vector(), c in vector()) {
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
    let quad = |low: f32, high: f32, material| {
        let at = |x: f32, z: f32| Vec3::new(x, 2.4, z);
        let [a, b, c, d] = [at(low, -1.0), at(low, 9.0), at(high, 9.0), at(high, -1.0)];
        [[a, b, c], [a, c, d]].map(|corners| Triangle {
            corners,
            material,
            double_sided: false,
        })
    };
    [quad(-1.0, border, 0), quad(border, 9.0, 1)].concat()
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
    let layer = |y: f32, material| Triangle {
        corners: [(-9.0, -9.0), (-9.0, 40.0), (40.0, -9.0)].map(|(x, z)| Vec3::new(x, y, z)),
        material,
        double_sided: false,
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

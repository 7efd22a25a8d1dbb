//! Tests of propagation: spherical harmonics, energy, symmetry.

use crate::support::{gray, images_in_cube, propagation, room, solid, sun, unit_grid};
use bevy_voxel_gi::reference::{
    IrradianceField, Light, Material, Voxels,
    propagate::{FRONT_ANGLE, SIDE_ANGLE, Y0, basis, cosine_lobe, flux},
    rays::sphere_ray,
};
use glam::{Vec3, Vec4};
use proptest::prelude::*;
use std::f32::consts::PI;

/// The steps of the default settings.
const STEPS: u32 = 128;

/// Directions with equal solid angles.
fn sphere(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| sphere_ray(i, count, 0.0))
}

proptest! {
    #[test]
    fn the_cosine_lobe_is_its_projection(n in [-1.0f32..1.0, -1.0..1.0, -1.0..1.0]) {
        let n = Vec3::from_array(n);
        prop_assume!(n.length() > 0.1);
        let n = n.normalize();
        const COUNT: u32 = 20_000;
        let sum: Vec4 = sphere(COUNT).map(|w| basis(w) * w.dot(n).max(0.0)).sum();
        let numeric = sum * 4.0 * PI / COUNT as f32;
        prop_assert!((numeric - cosine_lobe(n)).abs().max_element() < 2e-3);
        prop_assert!((flux(cosine_lobe(n)) - PI).abs() < 1e-5);
    }
}

#[test]
fn the_basis_is_orthonormal() {
    const COUNT: u32 = 20_000;
    for i in 0..4 {
        for j in 0..4 {
            let sum: f32 = sphere(COUNT).map(|w| basis(w)[i] * basis(w)[j]).sum();
            let numeric = sum * 4.0 * PI / COUNT as f32;
            assert!((numeric - f32::from(u8::from(i == j))).abs() < 1e-3);
        }
    }
    assert!((Y0 - 0.5 / PI.sqrt()).abs() < 1e-7);
    assert!((FRONT_ANGLE + 4.0 * SIDE_ANGLE - 2.0 * PI / 3.0).abs() < 1e-5);
}

fn point_light(position: Vec3) -> [Light; 1] {
    [Light::Point {
        position,
        intensity: Vec3::new(10.0, 20.0, 50.0),
        cone: None,
        near: 0.0,
    }]
}

#[test]
fn the_flux_never_grows() {
    let scene = [
        room(Vec3::splat(1.2), Vec3::splat(10.8)),
        solid(Vec3::new(3.1, 1.2, 4.0), Vec3::new(6.2, 5.5, 7.3)),
    ]
    .concat();
    let voxels = Voxels::new(unit_grid(12), &scene);
    for albedo in [0.99, 1.0] {
        let materials = gray(albedo, 0.0);
        let light = point_light(Vec3::new(8.0, 9.0, 3.0));
        let mut flow = propagation(&voxels, &materials, &light, Vec3::ZERO, STEPS);
        let mut last = flow.total_flux();
        assert!(last.min_element() > 0.0);
        for step in 0..1000 {
            flow.step();
            let now = flow.total_flux();
            assert!(now.cmple(last).all(), "step {step}: {now} after {last}");
            last = now;
        }
    }
}

/// All light of a closed room is absorbed by its walls: they receive 1 / (1 - albedo) of what they emit.
#[test]
fn furnace() {
    for albedo in [0.5, 0.9] {
        let voxels = Voxels::new(unit_grid(12), &room(Vec3::splat(0.5), Vec3::splat(11.5)));
        let materials = gray(albedo, 1.0);
        let mut flow = propagation(&voxels, &materials, &[], Vec3::ZERO, 1000);
        let given = flow.total_flux();
        flow.run();
        let walls = (0..voxels.grid.len()).filter(|v| voxels.masks[*v] != 0);
        let received: Vec3 = walls.flat_map(|v| flow.arrived[v]).sum();
        let ratio = received.as_dvec3() / given * (1.0 - f64::from(albedo));
        assert!((ratio - 1.0).abs().max_element() < 0.02, "{ratio}");
    }
}

/// The field with the default settings, without a sky.
fn propagated(voxels: &Voxels, materials: &[Material], light: &[Light]) -> IrradianceField {
    let mut flow = propagation(voxels, materials, light, Vec3::ZERO, STEPS);
    flow.run();
    flow.field()
}

#[test]
fn a_symmetric_scene_has_symmetric_light() {
    let voxels = Voxels::new(unit_grid(12), &room(Vec3::splat(1.0), Vec3::splat(11.0)));
    let materials = gray(0.6, 0.0);
    let light = point_light(Vec3::splat(6.0));
    let field = propagated(&voxels, &materials, &light);
    for (offset, found) in images_in_cube(&field) {
        for value in &found {
            assert!(
                (value / found[0] - 1.0).abs() < 1e-3,
                "{offset}: {value} of {}",
                found[0]
            );
        }
    }
}

#[test]
fn no_light_comes_through_a_wall() {
    let wall = solid(Vec3::new(7.2, -1.0, -1.0), Vec3::new(7.7, 20.0, 20.0));
    let voxels = Voxels::new(unit_grid(16), &wall);
    let light = [sun(Vec3::NEG_X, 1e5)];
    let materials = gray(0.9, 0.0);
    let field = propagated(&voxels, &materials, &light);
    let found = field.irradiance(Vec3::new(7.2, 8.0, 7.7), Vec3::NEG_X, 0.0);
    assert_eq!(found, Vec3::ZERO);
}

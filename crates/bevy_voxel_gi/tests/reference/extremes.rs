//! For extreme inputs, every output is finite.

use crate::support::{both, gray, is_sound, point_light, room, solid, sun, unit_grid};
use bevy_voxel_gi::reference::{Light, Triangle, light::Cone};
use glam::Vec3;
use proptest::prelude::*;

fn check(triangles: &[Triangle], albedo: f32, lights: &[Light], sky: Vec3) {
    let materials = gray(albedo, 0.0);
    let fields = both(unit_grid(12), triangles, &materials, lights, sky, 24);
    assert!(fields.iter().all(is_sound));
}

#[test]
fn bright_light_many_bounces() {
    let mut scene = room(Vec3::splat(1.3), Vec3::splat(10.6));
    scene.retain(|t| t.corners.iter().any(|c| c.y < 10.0));
    let sun = sun(Vec3::new(0.3, -0.9, 0.2), 130_000.0);
    check(&scene, 0.95, &[sun], Vec3::splat(5_000.0));
    for distance in [0.1, 0.01, 0.0] {
        let candela = 1e6 / (4.0 * std::f32::consts::PI);
        let light = point_light(Vec3::new(1.3 + distance, 5.0, 5.0), candela);
        check(&scene, 0.95, &[light], Vec3::ZERO);
    }
}

#[test]
fn no_light_no_geometry() {
    check(&[], 0.5, &[], Vec3::ZERO);
    check(&[], 0.5, &[], Vec3::ONE);
    let closed = room(Vec3::splat(1.3), Vec3::splat(10.6));
    check(&closed, 1.0, &[], Vec3::ZERO);
}

#[test]
fn geometry_half_outside() {
    for scene in [
        solid(Vec3::splat(-1e6), Vec3::splat(6.0)),
        room(Vec3::splat(-30.0), Vec3::splat(6.0)),
        solid(Vec3::splat(100.0), Vec3::splat(200.0)),
    ] {
        check(&scene, 0.8, &[], Vec3::ONE);
    }
}

#[test]
fn a_cone_fades() {
    let cone = Cone {
        direction: Vec3::NEG_Y,
        inner: 0.3,
        outer: 0.6,
    };
    assert_eq!(cone.attenuation(1.0), 1.0);
    assert_eq!(cone.attenuation(0.3f32.cos() + 1e-6), 1.0);
    assert_eq!(cone.attenuation(0.6f32.cos() - 1e-6), 0.0);
    assert!((0.2..0.3).contains(&cone.attenuation(0.5 * (0.3f32.cos() + 0.6f32.cos()))));
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -4.0f32..16.0,
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(-1e30f32),
        1 => Just(6.0f32),
        1 => Just(1e-40f32),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn any_triangles(
        corners in prop::collection::vec([number(), number(), number()], 3..30),
        light in [0.0f32..12.0, 0.0f32..12.0, 0.0f32..12.0],
        albedo in 0.0f32..=1.0,
        double_sided: bool,
        material in 0u32..5000,
    ) {
        let triangles: Vec<_> = corners.chunks_exact(3).map(|c| Triangle {
            corners: [c[0], c[1], c[2]].map(Vec3::from_array),
            material,
            double_sided,
        }).collect();
        let light = point_light(Vec3::from_array(light), 100.0);
        let fields = both(unit_grid(12), &triangles, &gray(albedo, 1.0), &[light], Vec3::ONE, 4);
        prop_assert!(fields.iter().all(is_sound));
    }
}

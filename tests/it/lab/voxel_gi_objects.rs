use bevy::{
    math::{Dir3, Vec3},
    prelude::Ray3d,
};
use bevy_frugal_lab::scenes::voxel_gi::*;

fn ray(direction: [f32; 3]) -> Ray3d {
    Ray3d {
        origin: Vec3::new(0.0, 2.0, 2.0),
        direction: Dir3::new(direction.into()).expect("a direction"),
    }
}

#[test]
fn a_ray_meets_what_is_before_it() {
    let ray = ray([0.0, -1.0, -1.0]);
    assert!(sphere_hit(ray, Vec3::new(0.1, 0.2, 0.0), 0.3).is_some());
    assert!(sphere_hit(ray, Vec3::new(1.0, 0.2, 0.0), 0.3).is_none());
    assert!(sphere_hit(ray, Vec3::new(0.0, 3.8, 4.0), 0.3).is_none());
    let floor = over_floor(ray, 0.5).expect("below");
    assert!(
        (floor - Vec3::new(0.0, 0.5, 0.5)).length() < 1e-5,
        "{floor}"
    );
}

#[test]
fn no_height_is_met_on_the_way_up() {
    assert!(over_floor(ray([0.0, 1.0, -1.0]), 0.5).is_none());
    assert!(over_floor(ray([0.0, 0.0, -1.0]), 0.5).is_none());
    assert!(over_floor(ray([0.0, -1.0, 0.0]), 2.5).is_none());
}

#[test]
fn walls_stop_objects() {
    let at = kept_inside(Vec3::new(9.0, 0.25, -9.0), 0.25);
    assert_eq!(at, Vec3::new(2.75, 0.25, -2.25));
    let at = Vec3::new(0.5, 0.25, 0.5);
    assert_eq!(kept_inside(at, 0.25), at);
}

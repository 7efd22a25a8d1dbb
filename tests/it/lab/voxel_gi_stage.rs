use std::f32::consts::FRAC_PI_2;

use bevy::{camera::Exposure, math::Vec3};

use bevy_frugal_lab::scenes::voxel_gi::stage::*;

#[test]
fn exposures_are_as_said() {
    for (ev100, expected) in [(EV100_OF_ONE, 1.0), (EV100, 0.25)] {
        let exposure = Exposure { ev100 }.exposure();
        assert!((exposure - expected).abs() < 1e-5, "{exposure}");
    }
}

#[test]
fn the_box_is_in_the_left_half_of_pictures_of_any_aspect() {
    for aspect in [1.0, 1.36, 16.0 / 9.0, 2.4] {
        let pose = view(aspect);
        let distance = pose.translation.z - FRONT;
        let half_height = distance * (0.5 * FOV.to_radians()).tan();
        let x = |x: f32| (x - pose.translation.x) / (half_height * aspect);
        // From -1 at the left edge to 1 at the right one.
        assert!(
            x(-1.1) > -1.0 && x(1.1) < 0.0,
            "{aspect}: {} {}",
            x(-1.1),
            x(1.1)
        );
        assert!((2.1 - pose.translation.y) / half_height < 1.0, "{aspect}");
    }
}

#[test]
fn the_door_turns_about_its_hinge_into_the_room() {
    let closed = door_pose(0.0, Vec3::ONE).translation;
    let open = door_pose(FRAC_PI_2, Vec3::ONE).translation;
    assert_eq!(closed, door().center);
    let from_hinge = |at: Vec3| (at - HINGE).with_y(0.0);
    assert!((from_hinge(open).length() - from_hinge(closed).length()).abs() < 1e-5);
    assert!(
        from_hinge(open).z > 0.4 && from_hinge(open).x.abs() < 1e-5,
        "{open}"
    );
}

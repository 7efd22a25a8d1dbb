//! The sun wanders, the door swings. At time 0 both are where the room has them.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::prelude::*;

use super::room;
use crate::runner::SceneSettings;

/// Seconds in which the sun wanders there and back.
const SUN_PERIOD: f32 = 40.0;
/// How far it wanders to each side, in radians.
const SUN: f32 = 0.35;
/// Seconds in which the door opens and closes.
const DOOR_PERIOD: f32 = 16.0;
/// Angle of the open door in radians.
const OPEN: f32 = 1.1 * FRAC_PI_2;

/// The room's sun, and the way that its light goes at time 0.
#[derive(Component)]
pub struct Sun(pub Vec3);

/// The room's door.
#[derive(Component)]
pub struct Door;

/// Turns the sun about the vertical.
pub fn move_sun(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    mut suns: Query<(&Sun, &mut Transform)>,
) {
    let phase = if settings.toggle("sun_motion") {
        (time.elapsed_secs() * TAU / SUN_PERIOD).sin()
    } else {
        0.0
    };
    for (Sun(direction), mut pose) in &mut suns {
        let direction = Quat::from_rotation_y(phase * SUN) * *direction;
        pose.set_if_neq(Transform::default().looking_to(direction, Vec3::Y));
    }
}

/// Turns the door about its hinge, into the room.
pub fn swing_door(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    mut doors: Query<&mut Transform, With<Door>>,
) {
    let angle = match settings.choice("door") {
        "closed" => 0.0,
        "open" => OPEN,
        _ => OPEN * 0.5 * (1.0 - (time.elapsed_secs() * TAU / DOOR_PERIOD).cos()),
    };
    for mut pose in &mut doors {
        pose.set_if_neq(door_pose(angle, pose.scale));
    }
}

fn door_pose(angle: f32, scale: Vec3) -> Transform {
    let mut pose = Transform::from_translation(room::door().center).with_scale(scale);
    pose.rotate_around(room::HINGE, Quat::from_rotation_y(-angle));
    pose
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_door_turns_about_its_hinge_into_the_room() {
        let closed = door_pose(0.0, Vec3::ONE).translation;
        let open = door_pose(FRAC_PI_2, Vec3::ONE).translation;
        assert_eq!(closed, room::door().center);
        let from_hinge = |at: Vec3| (at - room::HINGE).with_y(0.0);
        assert!((from_hinge(open).length() - from_hinge(closed).length()).abs() < 1e-5);
        assert!(
            from_hinge(open).z > 0.4 && from_hinge(open).x.abs() < 1e-5,
            "{open}"
        );
    }
}

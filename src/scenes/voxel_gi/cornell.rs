//! The Cornell box before the cameras: where they stand, their exposure, and the size of its traced picture.

use bevy::prelude::*;

use crate::{
    boxes::{BoxScene, cornell_box},
    stage::SceneCamera,
};

/// Exposure of the cameras before the box: 1 cd/m² is a quarter of white.
pub const EV100: f32 = EV100_OF_ONE + 2.0;
/// An exposure of exactly 1.
pub const EV100_OF_ONE: f32 = -0.263_034_4;
/// Vertical field of view of all cameras before the box, in degrees.
pub const FOV: f32 = 45.0;
/// Width of what a camera sees at the box's opening, in metres: its left half holds the box.
const WIDTH: f32 = 4.93;
/// The opening, in metres along Z.
const FRONT: f32 = 1.1;
/// Size of the traced picture in pixels.
pub const SIZE: UVec2 = UVec2::new(224, 128);

/// Where a camera with a picture of this aspect sees the box in the left half.
pub fn view(aspect: f32) -> Transform {
    // As far away as for the widest picture in which floor and ceiling are seen.
    let height = WIDTH / aspect.min(SIZE.x as f32 / SIZE.y as f32);
    let distance = 0.5 * height / (0.5 * FOV.to_radians()).tan();
    let aside = 0.25 * height * aspect;
    Transform::from_xyz(aside, 1.0, FRONT + distance)
}

/// The scene as the traced picture shows it.
pub fn scene() -> BoxScene {
    let pose = view(SIZE.x as f32 / SIZE.y as f32);
    BoxScene {
        camera: SceneCamera {
            eye: pose.translation,
            target: pose.translation - Vec3::Z,
            up: Vec3::Y,
            fov_y_deg: FOV,
            width: SIZE.x,
            height: SIZE.y,
        },
        ..cornell_box()
    }
}

#[cfg(test)]
mod tests {
    use bevy::camera::Exposure;

    use super::*;

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
}

//! The Cornell box in numbers.

use bevy::math::Vec3;

use super::{BoxScene, SceneBox, SceneCamera, ScenePointLight};

/// The Cornell box, 2 m wide, open in front, with a lamp of 10 cd that is a point under its
/// ceiling: the scene `cornell_point` of the path-traced data.
pub fn cornell_box() -> BoxScene {
    const WHITE: Vec3 = Vec3::splat(0.73);
    let part = |center: [f32; 3], half: [f32; 3], albedo: Vec3, rotate_y_deg: f32| SceneBox {
        center: center.into(),
        half: half.into(),
        albedo,
        rotate_y_deg,
    };
    BoxScene {
        name: "cornell_point".into(),
        boxes: vec![
            part([0.0, -0.05, 0.0], [1.1, 0.05, 1.1], WHITE, 0.0),
            part([0.0, 2.05, 0.0], [1.1, 0.05, 1.1], WHITE, 0.0),
            part(
                [-1.05, 1.0, 0.0],
                [0.05, 1.0, 1.1],
                Vec3::new(0.63, 0.06, 0.05),
                0.0,
            ),
            part(
                [1.05, 1.0, 0.0],
                [0.05, 1.0, 1.1],
                Vec3::new(0.14, 0.45, 0.09),
                0.0,
            ),
            part([0.0, 1.0, -1.05], [1.0, 1.0, 0.05], WHITE, 0.0),
            part([0.35, 0.3, 0.35], [0.3; 3], WHITE, -18.0),
            part([-0.35, 0.6, -0.3], [0.3, 0.6, 0.3], WHITE, 17.0),
        ],
        point_lights: vec![ScenePointLight {
            position: Vec3::new(0.0, 1.8, 0.0),
            intensity_cd: Vec3::splat(10.0),
        }],
        directional_lights: Vec::new(),
        sky_radiance: Vec3::ZERO,
        camera: SceneCamera {
            eye: Vec3::new(0.0, 1.0, 4.2),
            target: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::Y,
            fov_y_deg: 36.0,
            width: 128,
            height: 128,
        },
    }
}

//! The room in numbers: metres, lux and cd/m², Y up. Light comes in through a window at the right
//! and a door at the back.

use bevy::{color::LinearRgba, math::Vec3, transform::components::Transform};
use bevy_voxel_gi::Sky;

use crate::{
    boxes::{BoxScene, SceneBox},
    stage::{SceneCamera, SceneDirectionalLight},
};

/// Exposure of the cameras: the walls in bounced light are in the middle of the scale.
pub const EV100: f32 = 10.5;
/// Corners of where objects can be dragged.
pub const INSIDE: [Vec3; 2] = [Vec3::new(-3.0, 0.0, -2.5), Vec3::new(3.0, 2.7, 2.5)];
/// The edge about which the door turns.
pub const HINGE: Vec3 = Vec3::new(-2.2, 0.0, -2.55);
/// Where the red box begins: centre and half an edge.
pub const RED_BOX: (Vec3, f32) = (Vec3::new(1.45, 0.25, -0.1), 0.25);
/// Where the ball begins: centre and radius.
pub const BALL: (Vec3, f32) = (Vec3::new(-0.7, 0.28, -0.3), 0.28);

/// What the cameras look at.
const TARGET: Vec3 = Vec3::new(-0.35, 0.8, -2.5);
/// Thickness of the walls.
const WALL: f32 = 0.3;
/// Width, height and thickness of the door. Closed, its front is flush with the wall: beside a jamb that shows, voxels of
/// 0.2 m would leave an edge as bright as outside.
const DOOR: Vec3 = Vec3::new(1.0, 2.1, 0.1);

/// Light from outside: a clear sky, and sunlit ground below it.
pub fn sky() -> Sky {
    Sky {
        zenith: LinearRgba::rgb(2200.0, 3200.0, 5000.0),
        horizon: LinearRgba::rgb(4200.0, 4700.0, 5200.0),
        ground: LinearRgba::rgb(6500.0, 6000.0, 5000.0),
    }
}

/// Radiance of what cameras see where there is nothing, in cd/m².
pub const BACKGROUND: Vec3 = Vec3::new(4200.0, 4700.0, 5200.0);

/// Where the cameras are at the start.
pub fn view() -> Transform {
    Transform::from_xyz(0.9, 1.55, 2.35).looking_at(TARGET, Vec3::Y)
}

/// A box from corner to corner.
fn span(low: [f32; 3], high: [f32; 3], albedo: Vec3) -> SceneBox {
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    SceneBox {
        center: 0.5 * (low + high),
        half: 0.5 * (high - low),
        albedo,
        rotate_y_deg: 0.0,
        gloss: None,
    }
}

/// What does not move, and the sun.
pub fn room() -> BoxScene {
    const WHITE: Vec3 = Vec3::new(0.78, 0.76, 0.72);
    const WOOD: Vec3 = Vec3::new(0.45, 0.29, 0.17);
    const TERRACOTTA: Vec3 = Vec3::new(0.62, 0.25, 0.14);
    const MUSTARD: Vec3 = Vec3::new(0.72, 0.47, 0.1);
    const BLUE: Vec3 = Vec3::new(0.12, 0.25, 0.5);
    let [inner, outer] = [[3.0, 2.5], [3.0 + WALL, 2.5 + WALL]];
    let mut boxes = vec![
        // Floor and ceiling.
        span(
            [-outer[0], -WALL, -outer[1]],
            [outer[0], 0.0, outer[1]],
            WOOD,
        ),
        span(
            [-outer[0], 2.7, -outer[1]],
            [outer[0], 2.7 + WALL, outer[1]],
            WHITE,
        ),
        // Left, and in front.
        span(
            [-outer[0], 0.0, -outer[1]],
            [-inner[0], 2.7, outer[1]],
            TERRACOTTA,
        ),
        span([-inner[0], 0.0, inner[1]], [inner[0], 2.7, outer[1]], WHITE),
        // Right, around the window.
        span([inner[0], 0.0, -outer[1]], [outer[0], 0.9, outer[1]], WHITE),
        span([inner[0], 2.3, -outer[1]], [outer[0], 2.7, outer[1]], WHITE),
        span([inner[0], 0.9, -outer[1]], [outer[0], 2.3, -1.4], WHITE),
        span([inner[0], 0.9, 0.6], [outer[0], 2.3, outer[1]], WHITE),
        // At the back, around the door.
        span(
            [-inner[0], 0.0, -outer[1]],
            [HINGE.x, 2.7, -inner[1]],
            WHITE,
        ),
        span(
            [HINGE.x + DOOR.x, 0.0, -outer[1]],
            [inner[0], 2.7, -inner[1]],
            WHITE,
        ),
        span(
            [HINGE.x, DOOR.y, -outer[1]],
            [HINGE.x + DOOR.x, 2.7, -inner[1]],
            WHITE,
        ),
        // A sofa at the left.
        span([-2.95, 0.05, -0.6], [-2.05, 0.45, 1.4], MUSTARD),
        span([-2.98, 0.45, -0.6], [-2.7, 0.95, 1.4], MUSTARD),
        span([-2.7, 0.45, -0.6], [-2.05, 0.65, -0.4], MUSTARD),
        // A cabinet and a shelf at the back.
        span([1.3, 0.0, -2.48], [2.7, 0.95, -2.0], BLUE),
        span([-0.6, 1.5, -2.48], [0.9, 1.56, -2.2], WOOD),
        // A table with legs, and a rug.
        span([-0.5, 0.7, -1.95], [0.9, 0.76, -1.05], WHITE),
        span([-1.5, 0.0, -0.7], [0.7, 0.02, 0.9], BLUE),
    ];
    for (x, z) in [(-0.45, -1.9), (0.79, -1.9), (-0.45, -1.16), (0.79, -1.16)] {
        boxes.push(span([x, 0.0, z], [x + 0.06, 0.7, z + 0.06], WOOD));
    }
    BoxScene {
        name: "sunlit_room".into(),
        boxes,
        point_lights: Vec::new(),
        directional_lights: vec![SceneDirectionalLight {
            direction: Vec3::new(-0.74, -0.5, -0.12),
            illuminance_lux: Vec3::new(100_000.0, 94_000.0, 84_000.0),
        }],
        sky_radiance: Vec3::ZERO,
        sky_quarter: Vec3::ZERO,
        camera: SceneCamera {
            eye: view().translation,
            target: TARGET,
            up: Vec3::Y,
            fov_y_deg: 45.0,
            width: 640,
            height: 360,
        },
    }
}

/// The ground outside, which is larger than the volume.
pub fn ground() -> SceneBox {
    span(
        [-20.0, -WALL - 0.3, -20.0],
        [20.0, -WALL, 20.0],
        Vec3::new(0.4, 0.36, 0.28),
    )
}

/// The door, closed.
pub fn door() -> SceneBox {
    let low = HINGE - Vec3::new(0.0, 0.0, 0.5 * DOOR.z);
    span(
        low.to_array(),
        (low + DOOR).to_array(),
        Vec3::new(0.18, 0.42, 0.3),
    )
}

//! The chosen scene, the Cornell box or the room, the cameras before it, and the motion of sun and door.
//!
//! The room is in metres, lux and cd/m², Y up. Light comes in through a window at the right and a door at the back.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::{
    camera::Exposure,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    prelude::*,
};
use bevy_voxel_gi::Sky;

use crate::{
    boxes::{BoxScene, SceneBox, cornell_box, spawn_boxes_and_lights},
    runner::{PictureArea, SceneSettings, Side, Split},
    scenes::{
        Sun, TONE_MAPPED, UNGRADED, clear_sky, despawn_all, place_cameras, voxel_gi::Draggable,
    },
    stage::{SceneCamera, SceneDirectionalLight},
};

/// What is on stage.
#[derive(Resource, Default)]
pub struct Stage {
    name: &'static str,
    /// Size of the picture for which the cameras were placed.
    area: UVec2,
    scene: Option<BoxScene>,
    sky: Sky,
}

impl Stage {
    /// Centre and size in metres of a volume with this many voxels along an edge, and the sky around it.
    pub fn volume(&self, resolution: u32) -> Option<(Vec3, f32, Sky)> {
        let (center, size) = self.scene.as_ref()?.volume(resolution);
        Some((center, size, self.sky))
    }

    /// Whether it is the box with a path-traced picture.
    pub fn has_truth(&self) -> bool {
        self.name == "cornell"
    }
}

/// A part of the scene.
#[derive(Component)]
pub struct Part;

/// Puts the chosen scene on stage, and the cameras before it.
pub fn change(world: &mut World) {
    let name = world.resource::<SceneSettings>().choice("scene");
    let area = world.resource::<PictureArea>().0.size();
    if area.min_element() == 0 {
        return;
    }
    let stage = world.resource::<Stage>();
    let is_new = stage.name != name;
    // A window gets its final size a few frames after it has opened.
    if !is_new && (stage.area == area || name != "cornell") {
        return;
    }
    if is_new {
        despawn_all::<Part>(world);
        let (scene, sky) = match name {
            "cornell" => (spawn_cornell(world), Sky::default()),
            _ => (spawn_room(world), clear_sky()),
        };
        world.insert_resource(Stage {
            name,
            area,
            scene: Some(scene),
            sky,
        });
    } else {
        world.resource_mut::<Stage>().area = area;
    }
    let aspect = area.x as f32 / area.y as f32;
    let (pose, ev100, tone_map) = match name {
        // Not tone-mapped, as its truth.
        "cornell" => (view(aspect), EV100, UNGRADED),
        _ => (room_view(), ROOM_EV100, TONE_MAPPED),
    };
    let components = (pose, Exposure { ev100 }, tone_map);
    place_cameras::<(With<Side>, With<Camera>)>(world, components);
}

fn spawn_cornell(world: &mut World) -> BoxScene {
    let scene = cornell_box();
    let parts = spawn_boxes_and_lights(world, &scene);
    for part in parts {
        world.entity_mut(part).insert(Part);
    }
    world.insert_resource(ClearColor(Color::BLACK));
    // The right half is the path-traced picture's: the line starts in the middle of the left one.
    let mut split = world.resource_mut::<Split>();
    if *split == Split::default() {
        split.position = 0.25;
    }
    scene
}

fn spawn_room(world: &mut World) -> BoxScene {
    let scene = room();
    let mut outside = scene.clone();
    outside.directional_lights.clear();
    outside.boxes = vec![ground(), door()];
    let mut parts = spawn_boxes_and_lights(world, &scene);
    let sun = parts.last().copied();
    parts.extend(spawn_boxes_and_lights(world, &outside));
    let door = parts.last().copied();
    if let Some(sun) = sun {
        let shadows: CascadeShadowConfig = CascadeShadowConfigBuilder {
            num_cascades: 1,
            maximum_distance: 12.0,
            ..default()
        }
        .into();
        let direction = scene.directional_lights[0].direction;
        let swing = 0.35;
        world
            .entity_mut(sun)
            .insert((Sun { direction, swing }, shadows));
    }
    if let Some(door) = door {
        world.entity_mut(door).insert(Door);
    }
    let (box_center, half) = RED_BOX;
    let (ball_center, radius) = BALL;
    let objects = [
        (
            Mesh::from(Cuboid::from_length(2.0 * half)),
            LinearRgba::rgb(0.65, 0.05, 0.04),
            box_center,
            half,
        ),
        (
            Sphere::new(radius).mesh().uv(48, 24),
            LinearRgba::rgb(0.8, 0.8, 0.8),
            ball_center,
            radius,
        ),
    ];
    for (mesh, color, center, half) in objects {
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: color.into(),
                perceptual_roughness: 1.0,
                reflectance: 0.0,
                ..default()
            });
        let object = world.spawn((
            Draggable { half },
            Mesh3d(mesh),
            MeshMaterial3d(material),
            Transform::from_translation(center),
        ));
        parts.push(object.id());
    }
    for part in parts {
        world.entity_mut(part).insert(Part);
    }
    let exposure = Exposure { ev100: ROOM_EV100 }.exposure();
    let background = clear_sky().horizon.to_vec3() * exposure;
    world.insert_resource(ClearColor(LinearRgba::from_vec3(background).into()));
    scene
}

/// Exposure of the cameras before the box: 1 cd/m² is a quarter of white.
pub const EV100: f32 = EV100_OF_ONE + 2.0;
/// An exposure of exactly 1.
pub const EV100_OF_ONE: f32 = -0.263_034_4;
/// Vertical field of view of all cameras before the box, in degrees.
pub const FOV: f32 = 45.0;
/// Width of what a camera sees at the box's opening, in metres: its left half holds the box.
const WIDTH: f32 = 4.93;
/// The opening, in metres along Z.
pub const FRONT: f32 = 1.1;
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

/// Seconds in which the door opens and closes.
const DOOR_PERIOD: f32 = 16.0;
/// Angle of the open door in radians.
const OPEN: f32 = 1.1 * FRAC_PI_2;

/// The room's door.
#[derive(Component)]
pub struct Door;

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

pub fn door_pose(angle: f32, scale: Vec3) -> Transform {
    let mut pose = Transform::from_translation(door().center).with_scale(scale);
    pose.rotate_around(HINGE, Quat::from_rotation_y(-angle));
    pose
}

/// Exposure of the cameras: the walls in bounced light are in the middle of the scale.
const ROOM_EV100: f32 = 10.5;
/// Corners of where objects can be dragged.
pub const INSIDE: [Vec3; 2] = [Vec3::new(-3.0, 0.0, -2.5), Vec3::new(3.0, 2.7, 2.5)];
/// The edge about which the door turns.
pub const HINGE: Vec3 = Vec3::new(-2.2, 0.0, -2.55);
/// Where the red box begins: centre and half an edge.
const RED_BOX: (Vec3, f32) = (Vec3::new(1.45, 0.25, -0.1), 0.25);
/// Where the ball begins: centre and radius.
const BALL: (Vec3, f32) = (Vec3::new(-0.7, 0.28, -0.3), 0.28);

/// What the cameras look at.
const TARGET: Vec3 = Vec3::new(-0.35, 0.8, -2.5);
/// Thickness of the walls.
const WALL: f32 = 0.3;
/// Width, height and thickness of the door. Closed, its front is flush with the wall: beside a jamb that shows, voxels of
/// 0.2 m would leave an edge as bright as outside.
const DOOR: Vec3 = Vec3::new(1.0, 2.1, 0.1);

/// Where the cameras are at the start.
pub fn room_view() -> Transform {
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
fn room() -> BoxScene {
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
            eye: room_view().translation,
            target: TARGET,
            up: Vec3::Y,
            fov_y_deg: 45.0,
            width: 640,
            height: 360,
        },
    }
}

/// The ground outside, which is larger than the volume.
fn ground() -> SceneBox {
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

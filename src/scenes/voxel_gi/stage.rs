//! The chosen scene, and the cameras before it.

use bevy::{
    camera::Exposure,
    camera_controller::free_camera::FreeCameraState,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    prelude::*,
};
use bevy_voxel_gi::Sky;

use super::{cornell, drag::Draggable, motion, room};
use crate::{
    boxes::{BoxScene, cornell_box, spawn_boxes_and_lights},
    runner::{PictureArea, SceneSettings, Side, Split},
    scenes::tone::{TONE_MAPPED, UNGRADED},
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
        let mut parts = world.query_filtered::<Entity, With<Part>>();
        for part in parts.iter(world).collect::<Vec<_>>() {
            world.despawn(part);
        }
        let (scene, sky) = match name {
            "cornell" => (spawn_cornell(world), Sky::default()),
            _ => (spawn_room(world), room::sky()),
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
        "cornell" => (cornell::view(aspect), cornell::EV100, UNGRADED),
        _ => (room::view(), room::EV100, TONE_MAPPED),
    };
    let mut cameras = world.query_filtered::<Entity, (With<Side>, With<Camera>)>();
    for camera in cameras.iter(world).collect::<Vec<_>>() {
        let mut camera = world.entity_mut(camera);
        camera.insert((pose, Exposure { ev100 }, tone_map));
        // It would turn back to where it looked before.
        if camera.contains::<FreeCameraState>() {
            camera.insert(FreeCameraState::default());
        }
    }
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
    let scene = room::room();
    let mut outside = scene.clone();
    outside.directional_lights.clear();
    outside.boxes = vec![room::ground(), room::door()];
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
        world
            .entity_mut(sun)
            .insert((motion::Sun(direction), shadows));
    }
    if let Some(door) = door {
        world.entity_mut(door).insert(motion::Door);
    }
    let (box_center, half) = room::RED_BOX;
    let (ball_center, radius) = room::BALL;
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
    let exposure = Exposure { ev100: room::EV100 }.exposure();
    let background = room::BACKGROUND * exposure;
    world.insert_resource(ClearColor(LinearRgba::from_vec3(background).into()));
    scene
}

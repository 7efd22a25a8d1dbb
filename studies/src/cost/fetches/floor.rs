//! A floor that fills the picture, seen from near and far, with one light that has shadows.

use bevy::{
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    mesh::VertexAttributeValues,
    prelude::*,
};

use crate::cost::{
    app::{add_plugin, spawn_camera, spawn_light, spawn_volume},
    configurations::Kind,
    error::CostError,
    scene::Scene,
    skin::Skin,
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings, TargetFormat};

/// Size of the picture in pixels.
const SIZE: [u32; 2] = [160, 90];
/// Side of the textures in pixels.
const TEXTURE: u32 = 256;
/// Edge of the floor in metres, and how many textures there are along it.
const FLOOR: f32 = 120.0;
const TEXTURES: f32 = 80.0;
/// Height of the camera in metres.
const HEIGHT: f32 = 1.6;
/// The camera looks down by this angle in degrees. Half its vertical field of view is 22.5 degrees, so the floor is
/// seen under 4.5 to 49.5 degrees.
const PITCH: f32 = 27.0;

/// The app, before its first frame. Its picture is what the pixels return.
///
/// # Errors
/// [`CostError::App`] where there is no adapter.
pub fn app(kind: &Kind, scene: Scene) -> Result<HeadlessApp, CostError> {
    let settings = HeadlessSettings {
        format: TargetFormat::Float32,
        ..HeadlessSettings::with_size(SIZE[0], SIZE[1])
    };
    let mut app = HeadlessApp::new(settings, |app| add_plugin(app, kind))?;
    let world = app.world_mut();
    spawn_camera(world, kind, scene);
    let place = Transform::from_xyz(0.0, HEIGHT, 0.0)
        .with_rotation(Quat::from_rotation_x(-PITCH.to_radians()));
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let cameras: Vec<_> = cameras.iter(world).collect();
    for camera in cameras {
        let as_it_is = (Tonemapping::None, DebandDither::Disabled);
        world.entity_mut(camera).insert((place, as_it_is));
    }
    spawn_light(world, Vec3::new(0.0, 3.0, -4.0));
    spawn_volume(world, kind);
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(floor()?));
    let skin = Skin::new(world, kind, scene, TEXTURE);
    skin.put_on(world.spawn(mesh));
    Ok(app)
}

fn floor() -> Result<Mesh, CostError> {
    let plane = Plane3d::default().mesh().size(FLOOR, FLOOR).build();
    let mut mesh = plane
        .with_generated_tangents()
        .map_err(|error| CostError::Failed(error.to_string()))?;
    if let Some(VertexAttributeValues::Float32x2(uvs)) = mesh.attribute_mut(Mesh::ATTRIBUTE_UV_0) {
        for uv in uvs {
            *uv = uv.map(|coordinate| coordinate * TEXTURES);
        }
    }
    Ok(mesh)
}

//! A scene of meshes in Bevy, in units of the scene: a pixel's value is its radiance.

use std::{collections::HashMap, sync::Arc};

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

use super::{
    scene::{MeshScene, SceneMaterial, SceneMesh, ScenePart},
    texture::SceneTexture,
};
use crate::{
    content::mipped_texture,
    stage::{spawn_camera, spawn_lights},
};

/// The entities of a scene.
pub struct SpawnedScene {
    /// The parts, in the order of the scene.
    pub parts: Vec<Entity>,
    /// The lights, point lights first.
    pub lights: Vec<Entity>,
}

/// Spawns parts, lights and camera; the sky is left out.
pub fn spawn_mesh_scene(world: &mut World, scene: &MeshScene) -> SpawnedScene {
    let mut materials = SpawnedMaterials::default();
    let mut parts = Vec::new();
    for part in &scene.parts {
        let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh(&part.mesh));
        let material = materials.spawned(world, &part.material);
        let entity = world.spawn((Mesh3d(mesh), MeshMaterial3d(material), pose(part)));
        parts.push(entity.id());
    }
    let stage = &scene.stage;
    let lights = spawn_lights(world, &stage.point_lights, &stage.directional_lights);
    spawn_camera(world, &stage.camera);
    SpawnedScene { parts, lights }
}

/// Moves the parts and the point lights of a spawned scene to where they are in another one of the same parts.
pub fn move_to(world: &mut World, spawned: &SpawnedScene, scene: &MeshScene) {
    let lights = scene.stage.point_lights.iter();
    let lights = lights.map(|light| Transform::from_translation(light.position));
    let moved = spawned.lights.iter().zip(lights);
    let parts = spawned.parts.iter().zip(scene.parts.iter().map(pose));
    for (entity, wanted) in moved.chain(parts) {
        if let Some(mut pose) = world.get_mut::<Transform>(*entity) {
            pose.set_if_neq(wanted);
        }
    }
}

fn pose(part: &ScenePart) -> Transform {
    Transform::from_translation(part.translation).with_rotation(part.rotation)
}

fn mesh(mesh: &SceneMesh) -> Mesh {
    let usage = RenderAssetUsages::default();
    Mesh::new(PrimitiveTopology::TriangleList, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, mesh.positions.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, mesh.normals.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, mesh.uvs.clone())
        .with_inserted_indices(Indices::U32(mesh.indices.clone()))
}

/// The assets of materials and textures, by their addresses.
#[derive(Default)]
struct SpawnedMaterials {
    materials: HashMap<*const SceneMaterial, Handle<StandardMaterial>>,
    images: HashMap<*const SceneTexture, Handle<Image>>,
}

impl SpawnedMaterials {
    fn spawned(
        &mut self,
        world: &mut World,
        material: &Arc<SceneMaterial>,
    ) -> Handle<StandardMaterial> {
        let address = Arc::as_ptr(material);
        if let Some(known) = self.materials.get(&address) {
            return known.clone();
        }
        let emission = LinearRgba::from_vec3(material.emission);
        let material = StandardMaterial {
            base_color: LinearRgba::from_vec3(material.albedo).into(),
            base_color_texture: self.image(world, material.texture.as_ref()),
            alpha_mode: material
                .alpha_cutoff
                .map_or(AlphaMode::Opaque, AlphaMode::Mask),
            double_sided: material.is_double_sided,
            cull_mode: (!material.is_double_sided)
                .then_some(bevy::render::render_resource::Face::Back),
            emissive: emission,
            emissive_texture: self.image(world, material.emissive_texture.as_ref()),
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        };
        let handle = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(material);
        self.materials.insert(address, handle.clone());
        handle
    }

    fn image(
        &mut self,
        world: &mut World,
        texture: Option<&Arc<SceneTexture>>,
    ) -> Option<Handle<Image>> {
        let texture = texture?;
        let known = self.images.entry(Arc::as_ptr(texture));
        let handle = known.or_insert_with(|| {
            let mut image = mipped_texture(&texture.pixels, true);
            // Its mean colour is read on the CPU.
            image.asset_usage = RenderAssetUsages::default();
            world.resource_mut::<Assets<Image>>().add(image)
        });
        Some(handle.clone())
    }
}

//! Scenes of meshes with textures, in plain numbers: for Bevy and for the path tracer.

use std::{collections::HashMap, sync::Arc};

use bevy::{
    asset::RenderAssetUsages,
    math::{Affine3A, Quat, Vec2, Vec3, Vec4},
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_wavelet_tex::codec::color::linear_from_srgb;
use image::RgbaImage;

use crate::{
    content::mipped_texture,
    stage::{Stage, spawn_camera, spawn_lights, volume_around},
};

pub use crate::meshes::triangles::{TriangleBvh, trace};

pub mod arcade;
mod shapes;
pub mod town;
mod triangles;

/// A scene of meshes.
#[derive(Clone, Debug)]
pub struct MeshScene {
    /// The meshes, where they are.
    pub parts: Vec<ScenePart>,
    /// Lights, sky and camera.
    pub stage: Stage,
}

/// A mesh at a position.
#[derive(Clone, Debug)]
pub struct ScenePart {
    /// The geometry.
    pub mesh: Arc<SceneMesh>,
    /// The material.
    pub material: Arc<SceneMaterial>,
    /// The position of the mesh's origin in metres.
    pub translation: Vec3,
    /// The rotation about that origin.
    pub rotation: Quat,
}

impl ScenePart {
    /// A part that is not rotated.
    pub fn new(mesh: SceneMesh, material: &Arc<SceneMaterial>, translation: Vec3) -> Self {
        Self {
            mesh: Arc::new(mesh),
            material: material.clone(),
            translation,
            rotation: Quat::IDENTITY,
        }
    }

    /// From the mesh to the world.
    pub fn world_from_mesh(&self) -> Affine3A {
        Affine3A::from_rotation_translation(self.rotation, self.translation)
    }
}

/// Triangles; their front sides are counter-clockwise.
#[derive(Clone, Debug, Default)]
pub struct SceneMesh {
    /// Positions in metres.
    pub positions: Vec<Vec3>,
    /// Unit normals, as many as positions.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, as many as positions.
    pub uvs: Vec<Vec2>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

/// A Lambertian material.
#[derive(Clone, Debug)]
pub struct SceneMaterial {
    /// Diffuse albedo per channel, 0 to 1, where there is no texture; a factor of the texture's texels
    /// otherwise.
    pub albedo: Vec3,
    /// The albedo's texture.
    pub texture: Option<Arc<SceneTexture>>,
    /// Where the texture's alpha is below this, there is a hole.
    pub alpha_cutoff: Option<f32>,
    /// Both sides reflect light; the back is black otherwise.
    pub is_double_sided: bool,
    /// Radiance that the front emits, in cd/m²; a factor of the texels of `emissive_texture`, if there is one.
    pub emission: Vec3,
    /// The emission's texture.
    pub emissive_texture: Option<Arc<SceneTexture>>,
}

impl Default for SceneMaterial {
    /// A single-sided white without textures.
    fn default() -> Self {
        Self {
            albedo: Vec3::ONE,
            texture: None,
            alpha_cutoff: None,
            is_double_sided: false,
            emission: Vec3::ZERO,
            emissive_texture: None,
        }
    }
}

impl MeshScene {
    /// Corners of the bounds of all parts.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in &self.parts {
            let world_from_mesh = part.world_from_mesh();
            for position in &part.mesh.positions {
                let position = world_from_mesh.transform_point3(*position);
                bounds = (bounds.0.min(position), bounds.1.max(position));
            }
        }
        bounds
    }

    /// Centre and edge of the smallest volume of this many voxels along an edge that leaves one free on each side.
    pub fn volume(&self, resolution: u32) -> (Vec3, f32) {
        volume_around(self.bounds(), resolution)
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        let indices = self.parts.iter().map(|part| part.mesh.indices.len());
        indices.sum::<usize>() / 3
    }
}

/// A colour image that repeats in both directions.
#[derive(Clone, Debug)]
pub struct SceneTexture {
    /// Encoded in sRGB; alpha is linear.
    pub pixels: RgbaImage,
    /// The same, linear.
    texels: Vec<Vec4>,
}

impl SceneTexture {
    pub fn new(pixels: RgbaImage) -> Self {
        let texels = pixels.pixels().map(|pixel| {
            let [r, g, b, a] = pixel.0.map(|byte| f32::from(byte) / 255.0);
            let [r, g, b] = [r, g, b].map(linear_from_srgb);
            Vec4::new(r, g, b, a)
        });
        Self {
            texels: texels.collect(),
            pixels,
        }
    }

    /// The bilinearly interpolated texel, linear.
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        let size = [self.pixels.width() as i32, self.pixels.height() as i32];
        let at = uv * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
        let (corner, part) = (at.floor(), at - at.floor());
        let texel = |dx: i32, dy: i32| {
            let x = (corner.x as i32 + dx).rem_euclid(size[0]);
            let y = (corner.y as i32 + dy).rem_euclid(size[1]);
            self.texels[(y * size[0] + x) as usize]
        };
        let row = |dy| texel(0, dy).lerp(texel(1, dy), part.x);
        row(0).lerp(row(1), part.y)
    }
}

/// The entities of a scene.
pub struct SpawnedScene {
    /// The parts, in the order of the scene.
    pub parts: Vec<Entity>,
    /// The lights, point lights first.
    pub lights: Vec<Entity>,
    /// The camera.
    pub camera: Entity,
}

/// Spawns parts, lights and camera; the sky is left out.
pub fn spawn_mesh_scene(world: &mut World, scene: &MeshScene) -> SpawnedScene {
    let mut materials = SpawnedMaterials::default();
    let mut parts = Vec::new();
    for part in &scene.parts {
        let mesh = world.add_asset(mesh(&part.mesh));
        let material = materials.spawned(world, &part.material);
        let entity = world.spawn((Mesh3d(mesh), MeshMaterial3d(material), pose(part)));
        parts.push(entity.id());
    }
    let stage = &scene.stage;
    let lights = spawn_lights(world, &stage.point_lights, &stage.directional_lights);
    let camera = spawn_camera(world, &stage.camera);
    SpawnedScene {
        parts,
        lights,
        camera,
    }
}

/// Moves the parts, the point lights and the camera of a spawned scene to where they are in another one of the same
/// parts.
pub fn move_to(world: &mut World, spawned: &SpawnedScene, scene: &MeshScene) {
    let lights = scene.stage.point_lights.iter();
    let lights = lights.map(|light| Transform::from_translation(light.position));
    let moved = spawned.lights.iter().zip(lights);
    let parts = spawned.parts.iter().zip(scene.parts.iter().map(pose));
    let camera = (&spawned.camera, scene.stage.camera.pose());
    for (entity, target) in moved.chain(parts).chain([camera]) {
        if let Some(mut pose) = world.get_mut::<Transform>(*entity) {
            pose.set_if_neq(target);
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
        let handle = world.add_asset::<StandardMaterial>(material);
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
            world.add_asset(image)
        });
        Some(handle.clone())
    }
}

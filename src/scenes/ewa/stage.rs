//! The tunnel and the floor.

use std::f32::consts::TAU;

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageSampler, ImageSamplerDescriptor},
    math::Affine2,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_ewa::EwaStandardMaterial;
use image::{Rgba, RgbaImage, buffer::ConvertBuffer};

use crate::{
    content,
    runner::{SceneSettings, Side},
    scenes::ewa::{ViewMaterial, ewa_settings},
};

/// Textures by which the surface drifts in a second.
const DRIFT: f32 = 0.1;

#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A checkered tunnel, unlit.
    Tunnel,
    /// Bricks in the sun.
    Floor,
}

impl Place {
    fn name(self) -> &'static str {
        match self {
            Self::Tunnel => "tunnel",
            Self::Floor => "floor",
        }
    }
}

/// The textures, for each anisotropy of a sampler that was asked for.
#[derive(Resource, Default)]
pub struct Textures(Vec<(u16, [Handle<Image>; 3])>);

impl Textures {
    /// Checks, bricks, and the normals of bricks.
    fn get(&mut self, anisotropy: u16, images: &mut Assets<Image>) -> [Handle<Image>; 3] {
        if let Some((_, textures)) = self.0.iter().find(|(known, _)| *known == anisotropy) {
            return textures.clone();
        }
        let bricks = content::bricks(512, 512, 5);
        let pictures: [(RgbaImage, bool); 3] = [
            (checks(), true),
            (bricks.color.convert(), true),
            (bricks.normal.convert(), false),
        ];
        let textures = pictures.map(|(picture, srgb)| {
            let mut image = content::mipped_texture(&picture, srgb);
            if let ImageSampler::Descriptor(sampler) = &mut image.sampler {
                *sampler = ImageSamplerDescriptor {
                    anisotropy_clamp: anisotropy,
                    ..sampler.clone()
                };
            }
            images.add(image)
        });
        self.0.push((anisotropy, textures.clone()));
        textures
    }
}

fn checks() -> RgbaImage {
    RgbaImage::from_fn(256, 256, |x, y| {
        if (x / 32 + y / 32) % 2 == 0 {
            Rgba([240, 236, 225, 255])
        } else {
            Rgba([24, 32, 52, 255])
        }
    })
}

/// Spawns both places for both sides, and a sun.
pub fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    for side in Side::BOTH {
        for (place, mesh) in [(Place::Tunnel, tunnel()), (Place::Floor, floor())] {
            commands.spawn((side, side.layers(), place, Mesh3d(meshes.add(mesh))));
        }
        commands.spawn((
            side.layers(),
            DirectionalLight {
                illuminance: 9000.0,
                ..default()
            },
            Transform::default().looking_to(Vec3::new(0.5, -0.6, -0.6), Vec3::Y),
        ));
    }
}

/// The inside of a cylinder of radius 1 along z, four textures around.
fn tunnel() -> Mesh {
    const SEGMENTS: u32 = 96;
    const HALF_LENGTH: f32 = 400.0;
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=SEGMENTS {
        let part = i as f32 / SEGMENTS as f32;
        let (sin, cos) = (part * TAU).sin_cos();
        for z in [-HALF_LENGTH, HALF_LENGTH] {
            positions.push([cos, sin, z]);
            normals.push([-cos, -sin, 0.0]);
            uvs.push([4.0 * part, 0.5 * z]);
        }
    }
    let faces = (0..SEGMENTS).flat_map(|i| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| 2 * i + k);
        [a, c, b, b, c, d]
    });
    mesh(positions, normals, uvs, faces.collect())
}

/// A plane one unit below the eye.
fn floor() -> Mesh {
    const HALF: f32 = 300.0;
    let corners = [[-HALF, -HALF], [-HALF, HALF], [HALF, HALF], [HALF, -HALF]];
    mesh(
        corners.map(|[x, z]| [x, -1.0, z]).to_vec(),
        vec![[0.0, 1.0, 0.0]; 4],
        corners.map(|[x, z]| [0.5 * x, 0.5 * z]).to_vec(),
        vec![0, 1, 2, 0, 2, 3],
    )
}

fn mesh(
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
) -> Mesh {
    let mut mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
    .with_inserted_indices(Indices::U32(indices));
    if let Err(error) = mesh.generate_tangents() {
        warn!("no tangents: {error}");
    }
    mesh
}

/// Shows the chosen place only.
pub fn show_place(settings: Res<SceneSettings>, mut places: Query<(&Place, &mut Visibility)>) {
    for (place, mut visibility) in &mut places {
        visibility.set_if_neq(if place.name() == settings.choice("place") {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        });
    }
}

/// Gives each surface the material that the settings ask for.
pub fn configure(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    mut textures: ResMut<Textures>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<EwaStandardMaterial>>,
    mut views: ResMut<Assets<ViewMaterial>>,
    places: Query<(Entity, &Side, &Place)>,
) {
    for (entity, side, place) in &places {
        let ewa = ewa_settings(&settings, *side);
        // A texture has one sampler, which the plugin raises: sides with other samplers have other textures.
        let anisotropy = ewa.sampler_anisotropy.max(ewa.texture_unit_anisotropy());
        let [checks, bricks, normals] = textures.get(anisotropy, &mut images);
        let color = match place {
            Place::Tunnel => checks,
            Place::Floor => bricks,
        };
        let mut entity = commands.entity(entity);
        let view = settings.choice("view");
        if view != "picture" {
            let material = views.add(ViewMaterial::new(view, &ewa, color));
            entity
                .remove::<MeshMaterial3d<EwaStandardMaterial>>()
                .insert(MeshMaterial3d(material));
            continue;
        }
        let tunnel = *place == Place::Tunnel;
        let base = StandardMaterial {
            base_color_texture: Some(color),
            normal_map_texture: (!tunnel).then_some(normals),
            unlit: tunnel,
            perceptual_roughness: 0.8,
            double_sided: true,
            cull_mode: None,
            ..default()
        };
        let material = materials.add(EwaStandardMaterial {
            base,
            extension: ewa.into(),
        });
        entity
            .remove::<MeshMaterial3d<ViewMaterial>>()
            .insert(MeshMaterial3d(material));
    }
}

/// Moves the textures. At time 0 they are where they belong.
pub fn drift(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    places: Query<&MeshMaterial3d<EwaStandardMaterial>>,
    mut materials: ResMut<Assets<EwaStandardMaterial>>,
) {
    let moved = if settings.toggle("motion") {
        (time.elapsed_secs() * DRIFT).fract()
    } else {
        0.0
    };
    let transform = Affine2::from_translation(Vec2::new(0.0, moved));
    for material in &places {
        let is_there = materials
            .get(&material.0)
            .is_some_and(|material| material.base.uv_transform == transform);
        if !is_there && let Some(mut material) = materials.get_mut(&material.0) {
            material.base.uv_transform = transform;
        }
    }
}

//! Meshes and the sun.

use std::f32::consts::TAU;

use bevy::{
    camera::visibility::RenderLayers, light::CascadeShadowConfigBuilder,
    mesh::VertexAttributeValues, prelude::*,
};
use bevy_voxel_gi::NotVoxelized;

use super::hall::{self, Cloth, HallPart, Matter};
use crate::runner::{AFTER_LAYER, BEFORE_LAYER, SceneSettings, Side};

/// Seconds in which the sun wanders there and back.
const SUN_PERIOD: f32 = 40.0;
/// How far it wanders to each side, in radians.
const SUN: f32 = 0.25;

#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct HasMatter(pub Matter);

#[derive(Component)]
pub struct Sun;

/// Spawns everything. Parts with textures are there twice, one for each side; light meets those of
/// after.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) -> Result {
    for part in hall::parts() {
        let mesh = Mesh3d(meshes.add(mesh(&part)?));
        let pose = Transform::from_translation(part.center)
            .with_rotation(Quat::from_rotation_y(part.turned));
        if let Some(color) = plain_color(part.matter) {
            let material = materials.add(StandardMaterial {
                base_color: color,
                perceptual_roughness: 1.0,
                reflectance: 0.1,
                ..default()
            });
            commands.spawn((mesh, pose, MeshMaterial3d(material)));
            continue;
        }
        for side in Side::BOTH {
            let mut entity = commands.spawn((
                HasMatter(part.matter),
                side,
                side.layers(),
                mesh.clone(),
                pose,
            ));
            if side == Side::Before {
                entity.insert(NotVoxelized);
            }
        }
    }
    commands.spawn((
        Sun,
        RenderLayers::from_layers(&[0, BEFORE_LAYER, AFTER_LAYER]),
        DirectionalLight {
            color: Color::linear_rgb(1.0, 0.94, 0.84),
            illuminance: hall::SUN_LUX,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            first_cascade_far_bound: 7.0,
            maximum_distance: 26.0,
            ..default()
        }
        .build(),
        Transform::default().looking_to(hall::SUN, Vec3::Y),
    ));
    Ok(())
}

fn plain_color(matter: Matter) -> Option<Color> {
    match matter {
        Matter::Cloth(Cloth::Red) => Some(Color::linear_rgb(0.62, 0.04, 0.03)),
        Matter::Cloth(Cloth::Blue) => Some(Color::linear_rgb(0.03, 0.12, 0.5)),
        Matter::Ground => Some(Color::linear_rgb(0.36, 0.34, 0.24)),
        _ => None,
    }
}

/// A box with coordinates in metres times the repetitions, or a card.
fn mesh(part: &HallPart) -> Result<Mesh> {
    let mut mesh = if part.size.z == 0.0 {
        Rectangle::from_size(part.size.truncate()).into()
    } else {
        Mesh::from(Cuboid::from_size(part.size))
    };
    if let Some(repeats) = part.repeats() {
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION);
        let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL);
        if let (
            Some(VertexAttributeValues::Float32x3(positions)),
            Some(VertexAttributeValues::Float32x3(normals)),
        ) = (positions, normals)
        {
            let uvs: Vec<[f32; 2]> = positions
                .iter()
                .zip(normals)
                .map(|(p, n)| {
                    let at = Vec3::from(*p) + part.center;
                    let uv = match Vec3::from(*n).abs().max_position() {
                        0 => Vec2::new(at.z, -at.y),
                        1 => Vec2::new(at.x, at.z),
                        _ => Vec2::new(at.x, -at.y),
                    };
                    (uv * repeats).to_array()
                })
                .collect();
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
        }
    }
    Ok(mesh.with_generated_tangents()?)
}

/// Turns the sun about the vertical. At time 0 it is where it belongs.
pub fn move_sun(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    mut suns: Query<&mut Transform, With<Sun>>,
) {
    let phase = if settings.toggle("sun_motion") {
        (time.elapsed_secs() * TAU / SUN_PERIOD).sin()
    } else {
        0.0
    };
    let direction = Quat::from_rotation_y(phase * SUN) * hall::SUN;
    for mut pose in &mut suns {
        pose.set_if_neq(Transform::default().looking_to(direction, Vec3::Y));
    }
}

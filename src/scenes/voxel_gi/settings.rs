//! What the knobs make of the volume.

use bevy::prelude::*;
use bevy_voxel_gi::{
    Bounces, DebugField, Receiver, Sky, Solver, VoxelGiDebug, VoxelGiVolume, VoxelLight, Voxelizer,
};

use super::stage::Stage;
use crate::runner::{Knobs, Side};

/// Points on each triangle of the stochastic voxeliser.
const POINTS: u32 = 256;
/// What is further away than this does not occlude, in parts of the scene's size.
const OCCLUSION_RADIUS: f32 = 0.2;

/// Renews the volume when a knob or the scene changes; only the camera of "after" sees its light.
pub fn apply(
    mut commands: Commands,
    knobs: Res<Knobs>,
    stage: Res<Stage>,
    volumes: Query<Entity, With<VoxelGiVolume>>,
) {
    if !knobs.is_changed() && !stage.is_changed() {
        return;
    }
    let Some((center, size, sky)) = stage.volume(&knobs) else {
        return;
    };
    let volume = (
        settings(&knobs, size, sky),
        Transform::from_translation(center),
    );
    match volumes.iter().next() {
        Some(entity) => {
            commands.entity(entity).insert(volume);
        }
        None => {
            commands.spawn((volume, Side::After.layers()));
        }
    }
}

/// Shows the chosen field to the camera of "after".
pub fn apply_debug(
    mut commands: Commands,
    knobs: Res<Knobs>,
    cameras: Query<(Entity, &Side, Has<VoxelGiDebug>), With<Camera>>,
) {
    let field = match knobs.choice("debug") {
        "occupancy" => Some(DebugField::Occupancy),
        "albedo" => Some(DebugField::Albedo),
        "normal" => Some(DebugField::Normal),
        "radiance" => Some(DebugField::Radiance),
        "irradiance" => Some(DebugField::Irradiance),
        _ => None,
    };
    for (camera, side, has_field) in &cameras {
        let mut camera = commands.entity(camera);
        match field.filter(|_| *side == Side::After) {
            Some(field) if !has_field || knobs.is_changed() => {
                camera.insert(VoxelGiDebug { field });
            }
            None if has_field => {
                camera.remove::<VoxelGiDebug>();
            }
            _ => {}
        }
    }
}

/// Voxels along an edge of the volume.
pub fn resolution(knobs: &Knobs) -> u32 {
    knobs.choice("resolution").parse().unwrap_or(32)
}

fn settings(knobs: &Knobs, size: f32, sky: Sky) -> VoxelGiVolume {
    let cascades = knobs.integer("cascades");
    let rays = knobs.integer("rays");
    let light = match knobs.choice("light") {
        "ambient_occlusion" => VoxelLight::AmbientOcclusion {
            radius: OCCLUSION_RADIUS * size,
            rays,
        },
        _ => VoxelLight::GlobalIllumination {
            solver: match knobs.choice("solver") {
                "propagate" => Solver::Propagate {
                    iterations: knobs.integer("iterations"),
                },
                _ => Solver::Trace { rays },
            },
            bounces: match knobs.choice("bounces").parse() {
                Ok(count) => Bounces::Count(count),
                Err(_) => Bounces::Endless,
            },
        },
    };
    VoxelGiVolume {
        // The first of several cascades is about the middle of the scene.
        size: if cascades > 1 { 0.5 * size } else { size },
        resolution: resolution(knobs),
        light,
        voxelizer: match knobs.choice("voxelizer") {
            "fragment_clipping" => Voxelizer::FragmentClipping,
            "geometry_clipping" => Voxelizer::GeometryClipping,
            "stochastic" => Voxelizer::Stochastic { points: POINTS },
            _ => Voxelizer::Conservative,
        },
        receiver: match knobs.choice("receiver") {
            "per_pixel" => Receiver::PerPixel,
            _ => Receiver::Interpolated,
        },
        sky,
        shadow_samples: knobs.integer("shadow_samples"),
        cascades,
        ..default()
    }
}

//! What the settings make of the volume.

use bevy::prelude::*;
use bevy_voxel_gi::{
    Bounces, DebugField, Receiver, Sky, Solver, VoxelGiDebug, VoxelGiSettings, VoxelGiVolume,
    VoxelLight, Voxelizer,
};

use super::stage::Stage;
use crate::runner::{SceneSettings, Side};

/// Points on each triangle of the stochastic voxeliser.
const POINTS: u32 = 1024;
/// What is further away than this does not occlude, in parts of the scene's size.
const OCCLUSION_RADIUS: f32 = 0.2;

/// Renews the volume when a setting or the scene changes; only the camera of "after" sees its light.
pub fn apply(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    stage: Res<Stage>,
    volumes: Query<Entity, With<VoxelGiVolume>>,
) {
    if !settings.is_changed() && !stage.is_changed() {
        return;
    }
    let Some((center, size, sky)) = stage.volume(resolution(&settings)) else {
        return;
    };
    commands.insert_resource(light_settings(&settings, size));
    let volume = (
        volume(&settings, size, sky),
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
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Side, Has<VoxelGiDebug>), With<Camera>>,
) {
    let field = match settings.choice("debug") {
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
            Some(field) if !has_field || settings.is_changed() => {
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
fn resolution(settings: &SceneSettings) -> u32 {
    settings.choice("resolution").parse().unwrap_or(32)
}

fn volume(settings: &SceneSettings, size: f32, sky: Sky) -> VoxelGiVolume {
    let cascades = settings.integer("cascades");
    VoxelGiVolume {
        // The first of several cascades is about the middle of the scene.
        size: if cascades > 1 { 0.5 * size } else { size },
        sky,
        cascades,
        ..default()
    }
}

fn light_settings(settings: &SceneSettings, size: f32) -> VoxelGiSettings {
    let rays = settings.integer("rays");
    let light = match settings.choice("light") {
        "ambient_occlusion" => VoxelLight::AmbientOcclusion {
            radius: OCCLUSION_RADIUS * size,
            rays,
        },
        _ => VoxelLight::GlobalIllumination {
            solver: match settings.choice("solver") {
                "propagate" => Solver::Propagate {
                    iterations: settings.integer("iterations"),
                },
                _ => Solver::Trace { rays },
            },
            bounces: match settings.choice("bounces").parse() {
                Ok(count) => Bounces::Count(count),
                Err(_) => Bounces::Endless,
            },
        },
    };
    VoxelGiSettings {
        resolution: resolution(settings),
        light,
        voxelizer: match settings.choice("voxelizer") {
            "fragment_clipping" => Voxelizer::FragmentClipping,
            "geometry_clipping" => Voxelizer::GeometryClipping,
            "stochastic" => Voxelizer::Stochastic { points: POINTS },
            _ => Voxelizer::Conservative,
        },
        receiver: match settings.choice("receiver") {
            "per_pixel" => Receiver::PerPixel,
            _ => Receiver::Interpolated,
        },
        shadow_samples: settings.integer("shadow_samples"),
        ..default()
    }
}

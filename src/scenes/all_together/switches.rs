//! What the switches make of the volume and the cameras.

use bevy::prelude::*;
use bevy_voxel_gi::{VoxelGiSettings, VoxelGiVolume};
use bevy_ycocg_fb::{FrameBufferQuality, YCoCgFrameBuffer};

use super::hall;
use crate::{
    runner::{SceneSettings, Side},
    scenes::tone::{TONE_MAPPED, UNGRADED},
};

/// Spawns, changes or despawns the volume. Only the camera of after sees its light.
pub fn place_volume(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    mut light: ResMut<VoxelGiSettings>,
    volumes: Query<(Entity, &VoxelGiVolume)>,
) {
    let (center, size) = hall::volume();
    light.resolution = settings.choice("resolution").parse().unwrap_or(32);
    let wanted = settings.toggle("voxel_gi").then(|| VoxelGiVolume {
        size,
        sky: hall::sky(),
        ..default()
    });
    match (volumes.iter().next(), wanted) {
        (Some((_, volume)), Some(wanted)) if *volume == wanted => {}
        (Some((entity, _)), Some(wanted)) => {
            commands.entity(entity).insert(wanted);
        }
        (Some((entity, _)), None) => commands.entity(entity).despawn(),
        (None, Some(wanted)) => {
            let pose = Transform::from_translation(center);
            commands.spawn((wanted, pose, Side::After.layers()));
        }
        (None, None) => {}
    }
}

/// Gives the cameras their frame buffer, their ambient light and their tone mapping.
pub fn configure_cameras(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Side), With<Camera>>,
) {
    for (camera, side) in &cameras {
        let on = |switch| *side == Side::After && settings.toggle(switch);
        let mut camera = commands.entity(camera);
        camera.insert(if on("ycocg_fb") {
            FrameBufferQuality::from(YCoCgFrameBuffer::default())
        } else {
            FrameBufferQuality::Exact
        });
        camera.insert(AmbientLight {
            color: Color::linear_rgb(1.0, 0.97, 0.92),
            brightness: if on("voxel_gi") { 0.0 } else { hall::AMBIENT },
            ..default()
        });
        camera.insert(match settings.choice("tone_mapping") {
            "none" => UNGRADED,
            _ => TONE_MAPPED,
        });
    }
}

//! The light probe through which Bevy reads the volume.

use bevy::{
    camera::visibility::RenderLayers,
    light::{IrradianceVolume, LightProbe},
    prelude::*,
};

use super::{place_volume::ActiveVolume, texture::STORAGE_SCALE};

/// Marks the probe: a separate entity, so that the volume's entity may have children and a scale.
#[derive(Component)]
pub(crate) struct VoxelGiProbe;

/// Keeps the probe in sync with the active volumes: its box surrounds all of them.
pub(crate) fn place_probe(
    mut commands: Commands,
    active: Res<ActiveVolume>,
    mut probes: Query<
        (
            Entity,
            &mut IrradianceVolume,
            &mut Transform,
            &mut GlobalTransform,
            &mut RenderLayers,
        ),
        With<VoxelGiProbe>,
    >,
) {
    let Some(volume) = &active.volume else {
        for (probe, ..) in &probes {
            commands.entity(probe).despawn();
        }
        return;
    };
    let light = IrradianceVolume {
        voxels: volume.texture.clone(),
        intensity: if volume.has_had_levels {
            // The shader applies the intensity of each level.
            STORAGE_SCALE.recip()
        } else {
            volume.levels[0].intensity / STORAGE_SCALE
        },
        affects_lightmapped_meshes: volume.settings.affects_lightmapped_meshes,
    };
    let (center, extent) = volume.bounds();
    let at = Transform::from_translation(center).with_scale(extent);
    let Ok((_, mut known, mut transform, mut global, mut layers)) = probes.single_mut() else {
        commands.spawn((
            Name::new("voxel GI probe"),
            VoxelGiProbe,
            light,
            LightProbe::new(),
            at,
            GlobalTransform::from(at),
            volume.layers.clone(),
        ));
        return;
    };
    let is_same = known.voxels == light.voxels
        && known.intensity == light.intensity
        && known.affects_lightmapped_meshes == light.affects_lightmapped_meshes;
    if !is_same {
        *known = light;
    }
    if *transform != at {
        *transform = at;
        // Transforms have been propagated already in this frame.
        *global = at.into();
    }
    layers.set_if_neq(volume.layers.clone());
}

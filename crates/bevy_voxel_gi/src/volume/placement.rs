//! Which volume is in use, and where it is.

use bevy::{
    camera::{Exposure, visibility::RenderLayers},
    prelude::*,
};
use bevy_frugal_hooks::{PatchState, ShaderPatches};

use super::texture::{texture, texture_size};
use crate::{
    receive::RECEIVER_PATCH,
    settings::{Solver, VoxelGiVolume, VoxelLight},
};

/// The volume that lights the app, where it is now.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedVolume {
    /// With every field in range.
    pub settings: VoxelGiVolume,
    /// Centre of all cascades.
    pub center: Vec3,
    /// What Bevy samples; see [`texture_size`].
    pub texture: Handle<Image>,
    /// The pixel's shader knows our layout; else it is that of a plain irradiance volume.
    pub patched: bool,
    /// Exposure of the camera, for emission that is not meant to be exposed.
    pub exposure: f32,
    /// Which cameras see its light.
    pub layers: RenderLayers,
}

impl PlacedVolume {
    /// Half the edge of the largest cascade in metres.
    pub fn outer_half_size(&self) -> f32 {
        0.5 * self.settings.size * self.outer_scale()
    }

    /// How much larger the largest cascade is than the smallest.
    fn outer_scale(&self) -> f32 {
        (1 << (self.settings.cascades - 1)) as f32
    }
}

/// The volume in use, if there is one.
#[derive(Resource, Default)]
pub(crate) struct ActiveVolume {
    pub volume: Option<PlacedVolume>,
    /// The user's entity.
    owner: Option<Entity>,
}

/// Chooses the volume and where it is, and keeps its texture.
pub(crate) fn place_volume(
    mut active: ResMut<ActiveVolume>,
    volumes: Query<(
        Entity,
        &VoxelGiVolume,
        &GlobalTransform,
        Option<&RenderLayers>,
    )>,
    transforms: Query<&GlobalTransform>,
    cameras: Query<(&Camera, Option<&Exposure>), With<Camera3d>>,
    patches: Res<ShaderPatches>,
    mut images: ResMut<Assets<Image>>,
) {
    let active = &mut *active;
    let patched = match patches.state(RECEIVER_PATCH) {
        Some(PatchState::Applied) => true,
        Some(PatchState::Pending) => return,
        _ => false,
    };
    if volumes.iter().len() > 1 {
        warn_once!(
            "voxel GI: there is more than one VoxelGiVolume; only the one spawned first lights \
             the scene. Use its `cascades` to cover more of the world"
        );
    }
    // Indices of entities are used again: the one in use stays.
    let chosen = active
        .owner
        .and_then(|owner| volumes.get(owner).ok())
        .or_else(|| volumes.iter().min_by_key(|(entity, ..)| entity.index()));
    let Some((owner, settings, transform, layers)) = chosen else {
        (active.volume, active.owner) = (None, None);
        return;
    };
    let settings = possible(settings.clamped(), patched);
    let anchor = settings
        .follow
        .and_then(|entity| transforms.get(entity).ok())
        .unwrap_or(transform)
        .translation();
    let exposure = cameras
        .iter()
        .find(|(camera, _)| camera.is_active)
        .and_then(|(_, exposure)| exposure.copied())
        .unwrap_or_default()
        .exposure();
    let size = texture_size(&settings, patched);
    let fits = |old: &&PlacedVolume| {
        let image = images.get(&old.texture);
        image.is_some_and(|image| image.texture_descriptor.size == size) && old.patched == patched
    };
    let texture = match active.volume.as_ref().filter(fits) {
        Some(old) => old.texture.clone(),
        None => images.add(texture(size)),
    };
    active.owner = Some(owner);
    active.volume = Some(PlacedVolume {
        center: snapped(anchor, &settings),
        settings,
        texture,
        patched,
        exposure,
        layers: layers.cloned().unwrap_or_default(),
    });
}

/// The settings without what cannot be had together.
fn possible(mut settings: VoxelGiVolume, patched: bool) -> VoxelGiVolume {
    let propagates = matches!(
        settings.light,
        VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { .. },
            ..
        }
    );
    if settings.cascades > 1 && !patched {
        warn_once!(
            "voxel GI: Bevy's irradiance volume shader is not the one this plugin was made for, \
             so the volume has one cascade only"
        );
    }
    if settings.cascades > 1 && propagates {
        warn_once!("voxel GI: light is propagated in one cascade only; use `Solver::March`");
    }
    if !patched || propagates {
        settings.cascades = 1;
    }
    settings
}

/// The nearest whole voxel of the largest cascade, so that what is voxelised does not swim as the
/// volume moves.
fn snapped(anchor: Vec3, settings: &VoxelGiVolume) -> Vec3 {
    let anchor = if anchor.is_finite() {
        anchor
    } else {
        Vec3::ZERO
    };
    if settings.follow.is_none() {
        return anchor;
    }
    let step = settings.voxel_size() * (1 << (settings.cascades - 1)) as f32;
    (anchor / step).round() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_volume_that_follows_moves_by_whole_voxels_of_its_largest_cascade() {
        let settings = VoxelGiVolume {
            size: 8.0,
            resolution: 32,
            cascades: 3,
            follow: Some(Entity::PLACEHOLDER),
            ..default()
        };
        for x in [-3.3_f32, 0.0, 0.49, 0.51, 1e3 + 0.2] {
            let at = snapped(Vec3::splat(x), &settings).x;
            assert!(
                (at - at.round()).abs() < 1e-6 && (at - x).abs() <= 0.5,
                "{at} for {x}"
            );
        }
        assert_eq!(snapped(Vec3::NAN, &settings), Vec3::ZERO);
        let still = VoxelGiVolume {
            follow: None,
            ..settings
        };
        assert_eq!(snapped(Vec3::splat(0.3), &still), Vec3::splat(0.3));
    }

    #[test]
    fn cascades_need_our_receiver_and_rays() {
        let settings = VoxelGiVolume {
            cascades: 3,
            ..default()
        };
        assert_eq!(possible(settings.clone(), true).cascades, 3);
        assert_eq!(possible(settings.clone(), false).cascades, 1);
        let light = VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations: 9 },
            bounces: default(),
        };
        assert_eq!(
            possible(VoxelGiVolume { light, ..settings }, true).cascades,
            1
        );
    }
}

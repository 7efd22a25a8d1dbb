//! Chooses the active volumes and places their levels in the world.

use std::cmp::Reverse;

use bevy::{
    camera::{Exposure, visibility::RenderLayers},
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    ecs::{change_detection::Tick, system::SystemChangeTick},
    prelude::*,
};
use bevy_frugal_hooks::{PatchState, ShaderPatches};

use super::texture::{texture, texture_size};
use crate::{
    budget::BudgetChoice,
    receive::RECEIVER_PATCH,
    settings::{Receiver, Sky, Solver, VoxelAlbedo, VoxelGiVolume, VoxelLight},
};

/// Greatest number of levels. Keep in sync with `volume.wesl`.
pub(crate) const MOST_LEVELS: usize = 8;

/// A cube of voxels: a volume, or a cascade of one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Level {
    /// The entity with the [`VoxelGiVolume`].
    pub owner: Entity,
    pub center: Vec3,
    /// Edge in metres.
    pub size: f32,
    pub sky: Sky,
    pub intensity: f32,
}

/// The active volumes and their current placement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedVolume {
    /// Settings of the first volume, with every field in range and the budget's choice applied.
    pub settings: VoxelGiVolume,
    /// The same without the budget's choice.
    pub own_settings: VoxelGiVolume,
    /// All volumes and cascades, the smallest_axis first; never empty.
    pub levels: Vec<Level>,
    /// The texture that Bevy samples; see [`texture_size`].
    pub texture: Handle<Image>,
    /// Whether the patch of Bevy's shader applies; else the texture is that of a plain irradiance volume.
    pub patched: bool,
    /// Exposure of the camera, for emission that exposure must not affect.
    pub exposure: f32,
    /// Render layers of the cameras that receive the light.
    pub layers: RenderLayers,
    /// Transforms of the cameras from which albedo is reprojected.
    pub viewpoints: Vec<GlobalTransform>,
}

impl PlacedVolume {
    /// Centre and edges of the box around all levels, in metres.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let half = |level: &Level| Vec3::splat(0.5 * level.size);
        let (low, high) = self
            .levels
            .iter()
            .map(|level| (level.center - half(level), level.center + half(level)))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        (0.5 * (low + high), high - low)
    }

    /// Edge of a voxel of a level in metres.
    pub fn voxel_size(&self, level: &Level) -> f32 {
        level.size / self.settings.resolution as f32
    }

    /// Whether the shader can read the texture without the placement of the levels.
    pub fn is_plain(&self) -> bool {
        is_plain(&self.settings, self.levels.len())
    }

    /// Whether pixels test the visibility of the voxels around them.
    pub fn is_per_pixel(&self) -> bool {
        self.patched && self.settings.receiver == Receiver::PerPixel
    }
}

/// See [`PlacedVolume::is_plain`].
pub(super) fn is_plain(settings: &VoxelGiVolume, levels: usize) -> bool {
    levels == 1 && settings.receiver == Receiver::Interpolated
}

/// The active volumes, if there are any.
#[derive(Resource, Default)]
pub(crate) struct ActiveVolume {
    pub volume: Option<PlacedVolume>,
}

/// The components of a volume.
type VolumeParts = (
    Entity,
    Ref<'static, VoxelGiVolume>,
    &'static GlobalTransform,
    Option<&'static RenderLayers>,
);

/// Chooses the active volumes and their placement, and allocates their texture.
pub(crate) fn place_volume(
    mut active: ResMut<ActiveVolume>,
    volumes: Query<VolumeParts>,
    transforms: Query<&GlobalTransform>,
    cameras: Query<(&Camera, Option<&Exposure>), With<Camera3d>>,
    seeing: Query<(&Camera, &GlobalTransform), (With<DepthPrepass>, With<DeferredPrepass>)>,
    patches: Res<ShaderPatches>,
    mut images: ResMut<Assets<Image>>,
    budget: Option<Res<BudgetChoice>>,
    now: SystemChangeTick,
) {
    let active = &mut *active;
    let patched = match patches.state(RECEIVER_PATCH) {
        Some(PatchState::Applied) => true,
        Some(PatchState::Pending) => return,
        _ => false,
    };
    // Entity indices are reused: they write_number the order only of volumes that are spawned at once.
    let mut all: Vec<_> = volumes.iter().collect();
    let age = |added: Tick| now.this_run().get().wrapping_sub(added.get());
    all.sort_by_key(|(entity, volume, ..)| (Reverse(age(volume.added())), entity.index()));
    let Some((_, settings, _, layers)) = all.first() else {
        active.volume = None;
        return;
    };
    let settings = possible(settings.clamped(), patched);
    let layers = layers.cloned().unwrap_or_default();
    if !patched && all.len() > 1 {
        warn_once!(
            "voxel GI: Bevy's irradiance volume shader is not the one this plugin was made for, \
             so only the VoxelGiVolume spawned first lights the scene"
        );
        all.truncate(1);
    }
    let mut levels = Vec::new();
    for (owner, own, transform, own_layers) in all {
        let own = possible(own.clamped(), patched);
        if !shares(&own, &settings) || own_layers.cloned().unwrap_or_default() != layers {
            warn_once!(
                "voxel GI: all VoxelGiVolumes share their render layers and settings, except \
                 `size`, `cascades`, `follow`, `sky` and `intensity`; those of the one spawned \
                 first are used. Give all of them the same values"
            );
        }
        if levels.len() + own.cascades as usize > MOST_LEVELS {
            warn_once!(
                "voxel GI: there are more than {MOST_LEVELS} cubes in total (volumes times their \
                 `cascades`); the volumes spawned last are left out. Use fewer cascades, or \
                 despawn volumes that are far away"
            );
            break;
        }
        let anchor = own
            .follow
            .and_then(|entity| transforms.get(entity).ok())
            .unwrap_or(transform)
            .translation();
        let center = snapped(anchor, &own, settings.resolution);
        levels.extend((0..own.cascades).map(|cascade| Level {
            owner,
            center,
            size: own.size * (1 << cascade) as f32,
            sky: own.sky,
            intensity: own.intensity,
        }));
    }
    levels.sort_by(|a, b| a.size.total_cmp(&b.size));
    let own_settings = settings;
    let settings = match budget.and_then(|budget| budget.chosen()) {
        Some(chosen) => chosen.applied(&own_settings),
        None => own_settings.clone(),
    };
    let exposure = cameras
        .iter()
        .find(|(camera, _)| camera.is_active)
        .and_then(|(_, exposure)| exposure.copied())
        .unwrap_or_default()
        .exposure();
    let viewpoints: Vec<_> = match settings.albedo {
        VoxelAlbedo::Reprojected => seeing
            .iter()
            .filter(|(camera, _)| camera.is_active)
            .map(|(_, transform)| *transform)
            .collect(),
        _ => Vec::new(),
    };
    if settings.albedo == VoxelAlbedo::Reprojected && viewpoints.is_empty() {
        warn_once!(
            "voxel GI: `VoxelAlbedo::Reprojected` takes albedo from cameras with `DepthPrepass` and \
             `DeferredPrepass`, and no active camera has both; the mean colours of materials are \
             used. Add both to a camera"
        );
    }
    let size = texture_size(&settings, levels.len(), patched);
    let fits = |old: &&PlacedVolume| {
        let image = images.get(&old.texture);
        image.is_some_and(|image| image.texture_descriptor.size == size) && old.patched == patched
    };
    let texture = match active.volume.as_ref().filter(fits) {
        Some(old) => old.texture.clone(),
        None => images.add(texture(size)),
    };
    active.volume = Some(PlacedVolume {
        levels,
        settings,
        own_settings,
        texture,
        patched,
        exposure,
        layers,
        viewpoints,
    });
}

/// Whether a volume's settings equal the first one's in all fields that volumes share.
fn shares(own: &VoxelGiVolume, first: &VoxelGiVolume) -> bool {
    let common = VoxelGiVolume {
        size: first.size,
        cascades: first.cascades,
        follow: first.follow,
        sky: first.sky,
        intensity: first.intensity,
        ..own.clone()
    };
    common == *first
}

/// Removes settings that cannot be combined.
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
             so each volume has one cascade only"
        );
    }
    if settings.receiver == Receiver::PerPixel && !patched {
        warn_once!(
            "voxel GI: Bevy's irradiance volume shader is not the one this plugin was made for, \
             so `Receiver::Interpolated` is used"
        );
        settings.receiver = Receiver::Interpolated;
    }
    if settings.cascades > 1 && propagates {
        warn_once!(
            "voxel GI: light is propagated in one cascade only; use `Solver::Trace`, or \
             several volumes side by side"
        );
    }
    if !patched || propagates {
        settings.cascades = 1;
    }
    settings
}

/// The nearest position in steps of whole voxels of the largest cascade, so that the voxelised scene
/// does not shimmer as the volume moves.
fn snapped(anchor: Vec3, settings: &VoxelGiVolume, resolution: u32) -> Vec3 {
    let anchor = if anchor.is_finite() {
        anchor
    } else {
        Vec3::ZERO
    };
    if settings.follow.is_none() {
        return anchor;
    }
    let outer = settings.size * (1 << (settings.cascades - 1)) as f32;
    let step = outer / resolution as f32;
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
            let at = snapped(Vec3::splat(x), &settings, 32).x;
            assert!(
                (at - at.round()).abs() < 1e-6 && (at - x).abs() <= 0.5,
                "{at} for {x}"
            );
        }
        assert_eq!(snapped(Vec3::NAN, &settings, 32), Vec3::ZERO);
        let still = VoxelGiVolume {
            follow: None,
            ..settings
        };
        assert_eq!(snapped(Vec3::splat(0.3), &still, 32), Vec3::splat(0.3));
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

    #[test]
    fn volumes_share_what_is_not_about_their_place() {
        let first = VoxelGiVolume::default();
        let own = VoxelGiVolume {
            size: 3.0,
            cascades: 2,
            sky: Sky::uniform(LinearRgba::WHITE),
            intensity: 2.0,
            ..default()
        };
        assert!(shares(&own, &first));
        let own = VoxelGiVolume {
            resolution: 64,
            ..own
        };
        assert!(!shares(&own, &first));
    }

    #[test]
    fn the_box_is_around_all_levels() {
        let level = |center: Vec3, size: f32| Level {
            owner: Entity::PLACEHOLDER,
            center,
            size,
            sky: default(),
            intensity: 1.0,
        };
        let placed = PlacedVolume {
            settings: default(),
            own_settings: default(),
            levels: vec![level(Vec3::X * 3.0, 2.0), level(Vec3::ZERO, 4.0)],
            texture: default(),
            patched: true,
            exposure: 1.0,
            layers: default(),
            viewpoints: Vec::new(),
        };
        let (center, extent) = placed.bounds();
        assert_eq!(center, Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(extent, Vec3::new(6.0, 4.0, 4.0));
    }
}

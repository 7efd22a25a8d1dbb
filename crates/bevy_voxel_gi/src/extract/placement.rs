//! Where the volumes are: their levels and the settings that they share.

use bevy::{camera::visibility::RenderLayers, prelude::*};

use crate::settings::{Receiver, Sky, Solver, VoxelGiVolume, VoxelLight};

/// A cube of voxels: a volume, or a cascade of one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedLevel {
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
    /// All volumes and cascades, the smallest first; never empty.
    pub levels: Vec<PlacedLevel>,
    /// The texture that Bevy samples; see [`texture_size`](super::texture::texture_size).
    pub texture: Handle<Image>,
    /// Whether the patch of Bevy's shader applies; else the texture is that of a plain irradiance volume.
    pub patched: bool,
    /// Whether pixels read the placement of the levels: it is so once a texture could not be read without.
    pub has_had_levels: bool,
    /// Exposure for emission that exposure must not affect: that of the active 3D camera that sees the volume's render
    /// layers, draws to a window, and does so last, in this order of importance.
    pub exposure: f32,
    /// Render layers of the cameras that receive the light.
    pub layers: RenderLayers,
    /// Render layers of the meshes and lights that count: these, and those of the cameras.
    pub scene_layers: RenderLayers,
    /// Transforms of the cameras from which albedo is reprojected.
    pub viewpoints: Vec<GlobalTransform>,
}

impl PlacedVolume {
    /// Centre and edges of the box around all levels, in metres.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let half = |level: &PlacedLevel| Vec3::splat(0.5 * level.size);
        let (low, high) = self
            .levels
            .iter()
            .map(|level| (level.center - half(level), level.center + half(level)))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        (0.5 * (low + high), high - low)
    }

    /// Edge of a voxel of a level in metres.
    pub fn voxel_size(&self, level: &PlacedLevel) -> f32 {
        level.size / self.settings.resolution as f32
    }

    /// Whether pixels test the visibility of the voxels around them.
    pub fn is_per_pixel(&self) -> bool {
        self.patched && self.settings.receiver == Receiver::PerPixel
    }
}

/// Whether a volume's settings equal the first one's in all fields that volumes share.
pub(super) fn has_shared_settings(own: &VoxelGiVolume, first: &VoxelGiVolume) -> bool {
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

/// Removes settings that cannot be combined, or that need the receiver's patch.
pub(super) fn supported(mut settings: VoxelGiVolume, patched: bool) -> VoxelGiVolume {
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
pub(super) fn snapped(anchor: Vec3, settings: &VoxelGiVolume, resolution: u32) -> Vec3 {
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
    fn cascades_need_the_patch_and_rays() {
        let settings = VoxelGiVolume {
            cascades: 3,
            ..default()
        };
        assert_eq!(supported(settings.clone(), true).cascades, 3);
        assert_eq!(supported(settings.clone(), false).cascades, 1);
        let light = VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations: 9 },
            bounces: default(),
        };
        assert_eq!(
            supported(VoxelGiVolume { light, ..settings }, true).cascades,
            1
        );
    }

    #[test]
    fn volumes_share_all_settings_but_their_placement() {
        let first = VoxelGiVolume::default();
        let own = VoxelGiVolume {
            size: 3.0,
            cascades: 2,
            sky: Sky::uniform(LinearRgba::WHITE),
            intensity: 2.0,
            ..default()
        };
        assert!(has_shared_settings(&own, &first));
        let own = VoxelGiVolume {
            resolution: 64,
            ..own
        };
        assert!(!has_shared_settings(&own, &first));
    }

    #[test]
    fn the_box_is_around_all_levels() {
        let level = |center: Vec3, size: f32| PlacedLevel {
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
            has_had_levels: true,
            exposure: 1.0,
            layers: default(),
            scene_layers: default(),
            viewpoints: Vec::new(),
        };
        let (center, extent) = placed.bounds();
        assert_eq!(center, Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(extent, Vec3::new(6.0, 4.0, 4.0));
    }
}

//! Where the volumes are: their levels and the settings that they share.

use bevy::{camera::visibility::RenderLayers, prelude::*};

use super::game_sky::SkyMap;
use crate::settings::{Follow, Receiver, Sky, VoxelGiSettings, VoxelGiVolume, VoxelLight};

/// A cube of voxels: a volume, or a cascade of one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedLevel {
    pub owner: Entity,
    pub center: Vec3,
    /// What it follows, or its centre: its light blends into that of the next level around it.
    pub focus: Vec3,
    /// The centre follows in steps of so many metres; 0 if it follows nothing.
    pub step: f32,
    /// Edge in metres.
    pub size: f32,
    pub sky: Sky,
    /// Whether rays see the game's own sky, too.
    pub sees_map: bool,
    pub intensity: f32,
    /// Whether only rays see it, and no pixel; see [`outer_levels`](super::outer_levels).
    pub is_outer: bool,
}

/// Width of the margin around a level in which its light fades, in voxels. Keep in sync with `receive.wesl`.
const MARGIN: f32 = 2.0;

/// The active volumes and their current placement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedVolume {
    /// The settings, with every field in range and the budget's choice applied.
    pub settings: VoxelGiSettings,
    /// The same without the budget's choice.
    pub own_settings: VoxelGiSettings,
    /// All volumes and cascades, the smallest first, never empty; then the levels around them.
    pub levels: Vec<PlacedLevel>,
    /// The texture that Bevy samples; see [`texture_size`](super::probe::texture_size).
    pub texture: Handle<Image>,
    /// Whether the patch of Bevy's shader applies; else the texture is that of a plain irradiance volume.
    pub patched: bool,
    /// Whether there were levels around one centre: pixels find theirs by its distance.
    pub has_had_cascades: bool,
    /// Whether pixels read the placement of the levels: it is so once a texture could not be read without.
    pub has_had_levels: bool,
    /// The game's own sky, if a level sees it, and a number that changes with it where the GPU draws it.
    pub sky_map: Option<SkyMap>,
    pub sky_revision: u64,
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
    /// The levels that light pixels.
    pub fn lit(&self) -> &[PlacedLevel] {
        let count = self.levels.iter().take_while(|level| !level.is_outer);
        &self.levels[..count.count()]
    }

    /// Centre and edges of the box around them and their margins, in metres.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let margin = if self.patched { MARGIN } else { 0.0 };
        let half =
            |level: &PlacedLevel| Vec3::splat(0.5 * level.size + margin * self.voxel_size(level));
        let (low, high) = self
            .lit()
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

    /// How far the focus of a level may be from its centre along an axis, in voxels.
    pub fn reach(&self, level: &PlacedLevel) -> f32 {
        0.5 * level.step / self.voxel_size(level)
    }

    /// Whether pixels test the visibility of the voxels around them.
    pub fn is_per_pixel(&self) -> bool {
        self.patched && self.settings.receiver == Receiver::PerPixel
    }

    /// Whether rough surfaces have specular light of the volume.
    pub fn is_specular(&self) -> bool {
        self.patched && self.settings.specular_light
    }
}

/// The settings as far as the receiver's patch is applied.
pub(super) fn supported(mut settings: VoxelGiSettings, patched: bool) -> VoxelGiSettings {
    if settings.receiver == Receiver::PerPixel && !patched {
        warn_once!(
            "voxel GI: Bevy's irradiance volume shader is not the one this plugin was made for, \
             so `Receiver::Interpolated` is used"
        );
        settings.receiver = Receiver::Interpolated;
    }
    settings
}

/// The number of cascades of a volume: several need the receiver's patch, and rays.
pub(super) fn cascades(volume: &VoxelGiVolume, light: VoxelLight, patched: bool) -> u32 {
    if volume.cascades > 1 && !patched {
        warn_once!(
            "voxel GI: Bevy's irradiance volume shader is not the one this plugin was made for, \
             so each volume has one cascade only"
        );
    }
    if patched && !light.propagates() {
        volume.cascades
    } else {
        1
    }
}

/// The steps in which a cascade follows: two of its voxels, or one of the largest, so that the voxelised scene does not
/// shimmer as the volume moves. 0 if it follows nothing.
pub(super) fn step(volume: &VoxelGiVolume, cascade: u32, resolution: u32) -> f32 {
    if volume.follow == Follow::Nothing {
        return 0.0;
    }
    let next = (cascade + 1).min(volume.cascades - 1);
    volume.size * (1 << next) as f32 / resolution as f32
}

/// The nearest position in such steps.
pub(super) fn snapped(position: Vec3, step: f32) -> Vec3 {
    if step > 0.0 {
        (position / step).round() * step
    } else {
        position
    }
}

#[cfg(test)]
impl PlacedLevel {
    /// A level under a black sky.
    pub fn of(center: Vec3, size: f32) -> Self {
        Self {
            owner: Entity::PLACEHOLDER,
            center,
            focus: center,
            step: 0.0,
            size,
            sky: default(),
            sees_map: false,
            intensity: 1.0,
            is_outer: false,
        }
    }
}

#[cfg(test)]
impl PlacedVolume {
    /// These levels with default settings.
    pub fn of(levels: Vec<PlacedLevel>) -> Self {
        Self {
            settings: default(),
            own_settings: default(),
            levels,
            texture: default(),
            patched: true,
            has_had_cascades: false,
            has_had_levels: false,
            sky_map: None,
            sky_revision: 0,
            exposure: 1.0,
            layers: default(),
            scene_layers: default(),
            viewpoints: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Solver;

    #[test]
    fn cascades_follow_by_whole_voxels_of_their_own_and_fixed_volumes_stay() {
        let volume = VoxelGiVolume {
            size: 8.0,
            cascades: 3,
            follow: Follow::Entity(Entity::PLACEHOLDER),
            ..default()
        };
        for x in [-3.3_f32, 0.0, 0.49, 0.51, 1e3 + 0.2] {
            for (cascade, step) in [(0, 0.5), (1, 1.0), (2, 1.0)] {
                assert_eq!(super::step(&volume, cascade, 32), step);
                let at = snapped(Vec3::splat(x), step).x;
                let steps = at / step;
                assert!(
                    (steps - steps.round()).abs() < 1e-6 && (at - x).abs() <= 0.5 * step,
                    "{at} for {x}"
                );
            }
        }
        let still = VoxelGiVolume {
            follow: Follow::Nothing,
            ..volume
        };
        assert_eq!(super::step(&still, 0, 32), 0.0);
        assert_eq!(snapped(Vec3::splat(0.3), 0.0), Vec3::splat(0.3));
    }

    #[test]
    fn cascades_need_the_patch_and_rays() {
        let volume = VoxelGiVolume {
            cascades: 3,
            ..default()
        };
        assert_eq!(cascades(&volume, default(), true), 3);
        assert_eq!(cascades(&volume, default(), false), 1);
        let light = VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations: 9 },
            bounces: default(),
        };
        assert_eq!(cascades(&volume, light, true), 1);
    }

    #[test]
    fn the_box_is_around_all_levels() {
        let placed = PlacedVolume::of(vec![
            PlacedLevel::of(Vec3::X * 3.0, 2.0),
            PlacedLevel::of(Vec3::ZERO, 4.0),
        ]);
        let (center, extent) = placed.bounds();
        // The larger one has a margin of a quarter of a metre, the smaller one of an eighth.
        assert_eq!(center, Vec3::new(0.9375, 0.0, 0.0));
        assert_eq!(extent, Vec3::new(6.375, 4.5, 4.5));
    }
}

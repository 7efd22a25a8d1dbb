//! A volume, and what it has for itself.

use bevy::prelude::*;

use super::{range::clamped_or, shared::VoxelGiSettings, sky::Sky};

/// A cube of the world in which light bounces.
///
/// Every entity with a `Mesh3d` in the cube is voxelised each frame, whether it is in a camera's view or
/// not, and every material in the cube that uses Bevy's lighting receives the indirect light without a
/// change. The cube is centred on the entity's position; the entity's rotation and scale are ignored. A volume
/// that is hidden (`Visibility`) is as one that is not there.
///
/// Cameras receive the light if they share a layer with the volume (`RenderLayers`; by default all are in layer 0).
/// Meshes and lights count if they share a layer with the volume or with such a camera. Of the levels of detail of a mesh (`VisibilityRange`), the one that is seen
/// at a distance of 0 counts, wherever cameras are.
///
/// There may be several volumes, side by side or nested: a pixel is lit by the smallest one that
/// contains it, and a ray that leaves a volume continues in a larger one that contains or adjoins it;
/// where there is none, the ray returns the sky of the volume that it left. What all volumes share is in
/// [`VoxelGiSettings`]; their render layers are those of the one spawned first. At most eight cubes
/// are supported, where each cascade of each volume counts as one; volumes beyond this limit are left
/// out with a warning.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
#[require(Transform, Visibility)]
pub struct VoxelGiVolume {
    /// Edge of the cube in metres, above 0. Default 16. With [`cascades`](Self::cascades), this is the
    /// edge of the smallest cube.
    pub size: f32,
    /// The light that comes from outside of the volume.
    pub sky: Sky,
    /// Number of concentric cubes, each twice as large as the one before, all of the same resolution:
    /// 1 to 4. Default 1. Each further cube takes as much memory as the first. When an app first has a second
    /// level, a cascade or another volume, a frame waits until the shaders of all materials are compiled again.
    pub cascades: u32,
    /// The entity that the volume follows, such as the camera, in steps of whole voxels of the largest
    /// cascade. Default `None`: the volume stays at its own position.
    #[entities]
    pub follow: Option<Entity>,
    /// Factor of the light that reaches the image, at least 0. Default 1, which is physically correct.
    pub intensity: f32,
}

impl Default for VoxelGiVolume {
    fn default() -> Self {
        Self {
            size: 16.0,
            sky: Sky::default(),
            cascades: 1,
            follow: None,
            intensity: 1.0,
        }
    }
}

impl VoxelGiVolume {
    /// Returns a copy with every field clamped to its range.
    pub fn clamped(&self) -> Self {
        Self {
            size: clamped_or(self.size, 1e-3, 1e6, 16.0),
            sky: self.sky.clamped(),
            cascades: self.cascades.clamp(1, 4),
            follow: self.follow,
            intensity: clamped_or(self.intensity, 0.0, 1e4, 1.0),
        }
    }

    /// Returns the edge of a voxel of the smallest cascade in metres.
    pub fn voxel_size(&self, settings: &VoxelGiSettings) -> f32 {
        self.size / settings.resolution as f32
    }
}

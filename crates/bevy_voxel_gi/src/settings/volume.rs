//! The settings of a volume.

use bevy::prelude::*;

use super::{light::VoxelLight, range::clamped_or, sky::Sky};

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
/// where there is none, the ray returns the sky of the volume that it left. All volumes use the settings
/// of the one spawned first, except [`size`](Self::size), [`cascades`](Self::cascades),
/// [`follow`](Self::follow), [`sky`](Self::sky) and [`intensity`](Self::intensity). At most eight cubes
/// are supported, where each cascade of each volume counts as one; volumes beyond this limit are left
/// out with a warning.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
#[require(Transform, Visibility)]
pub struct VoxelGiVolume {
    /// Edge of the cube in metres, above 0. Default 16. With [`cascades`](Self::cascades), this is the
    /// edge of the smallest cube.
    pub size: f32,
    /// Number of voxels along an edge, 8 to 128, a multiple of 4. Default 32. Memory grows with the cube
    /// of this number; see [`VoxelGiReport::memory`](crate::VoxelGiReport::memory). Where the device cannot
    /// bind buffers of that size, the number is lower, and a warning says so.
    pub resolution: u32,
    /// The light that is computed: global illumination or ambient occlusion.
    pub light: VoxelLight,
    /// The algorithm that converts meshes to voxels.
    pub voxelizer: Voxelizer,
    /// The source of the diffuse reflectance of surfaces.
    pub albedo: VoxelAlbedo,
    /// How a pixel samples the voxels around it.
    pub receiver: Receiver,
    /// The light that comes from outside of the volume.
    pub sky: Sky,
    /// Number of points of a voxel's surface that are tested for shadow, per light, 1 to 16. Default 16.
    /// Lower values cost less and make the edges of shadows coarser.
    pub shadow_samples: u32,
    /// Number of concentric cubes, each twice as large as the one before, all of the same resolution:
    /// 1 to 4. Default 1. Each further cube takes as much memory as the first. When an app first has a second
    /// level, a cascade or another volume, a frame waits until the shaders of all materials are compiled again.
    pub cascades: u32,
    /// The entity that the volume follows, such as the camera, in steps of whole voxels of the largest
    /// cascade. Default `None`: the volume stays at its own position.
    pub follow: Option<Entity>,
    /// Updates one n-th of the volume per frame, 1 to 16 (thesis section 6.9.1). Default 1: the whole
    /// volume is updated each frame. Higher values cost less per frame and respond to changes later;
    /// direct light is still computed for the whole volume each frame.
    pub update_interval: u32,
    /// Whether the computation stops once nothing has moved or changed for as long as the light needs
    /// to settle. Default `true`.
    pub pause_when_settled: bool,
    /// Whether meshes with a `Lightmap` receive the light, too. Default `false`: it is in their lightmaps already.
    /// With `true` they receive all of it, which is right where lightmaps have direct light only.
    pub affects_lightmapped_meshes: bool,
    /// Factor of the light that reaches the image, at least 0. Default 1, which is physically correct.
    pub intensity: f32,
}

impl Default for VoxelGiVolume {
    fn default() -> Self {
        Self {
            size: 16.0,
            resolution: 32,
            light: VoxelLight::default(),
            voxelizer: Voxelizer::default(),
            albedo: VoxelAlbedo::default(),
            receiver: Receiver::default(),
            sky: Sky::default(),
            shadow_samples: 16,
            cascades: 1,
            follow: None,
            update_interval: 1,
            pause_when_settled: true,
            affects_lightmapped_meshes: false,
            intensity: 1.0,
        }
    }
}

impl VoxelGiVolume {
    /// Returns a copy with every field clamped to its range.
    pub fn clamped(&self) -> Self {
        Self {
            size: clamped_or(self.size, 1e-3, 1e6, 16.0),
            resolution: (self.resolution / 4 * 4).clamp(8, 128),
            light: self.light.clamped(),
            voxelizer: self.voxelizer.clamped(),
            albedo: self.albedo,
            receiver: self.receiver,
            sky: self.sky.clamped(),
            shadow_samples: self.shadow_samples.clamp(1, 16),
            cascades: self.cascades.clamp(1, 4),
            follow: self.follow,
            update_interval: self.update_interval.clamp(1, 16),
            pause_when_settled: self.pause_when_settled,
            affects_lightmapped_meshes: self.affects_lightmapped_meshes,
            intensity: clamped_or(self.intensity, 0.0, 1e4, 1.0),
        }
    }

    /// Returns the edge of a voxel of the smallest cascade in metres.
    pub fn voxel_size(&self) -> f32 {
        self.size / self.resolution as f32
    }
}

/// The algorithm that converts meshes to voxels.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Voxelizer {
    /// Fills every voxel that a triangle overlaps, without holes.
    #[default]
    Conservative,
    /// Fragment clipping (thesis section 6.4.2): triangles are rasterised whole, and each fragment is in the
    /// slice of its depth. Sampled, not conservative.
    FragmentClipping,
    /// Geometry clipping (thesis section 6.4.2): triangles are clipped to slices first, then
    /// rasterised. It gives the same voxels at another cost.
    GeometryClipping,
    /// Random points on each triangle (thesis section 6.4.3): a voxel with a point gets the triangle's plane, within the
    /// triangle's bounds. Large triangles get holes; on fine meshes, 16 points have the light of
    /// [`Conservative`](Self::Conservative) to a tenth of its error.
    ///
    /// With [`VoxelAlbedo::Reprojected`], what cameras see is voxelised as well, which fills holes where they look: until
    /// the light has settled, the scene is voxelised in each frame together with what cameras saw in the frame before,
    /// and since meshes or the volume last moved. This includes meshes with `NotVoxelized`, and normals include those of
    /// normal maps. Light then depends on where cameras look. It takes 32 bytes per voxel.
    Stochastic {
        /// Number of points on each triangle, 1 to 1024.
        points: u32,
    },
}

impl Voxelizer {
    fn clamped(self) -> Self {
        match self {
            Self::Stochastic { points } => Self::Stochastic {
                points: points.clamp(1, 1024),
            },
            other => other,
        }
    }
}

/// The source of the diffuse reflectance of surfaces (thesis section 6.5.2).
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VoxelAlbedo {
    /// One colour per material: its base colour times the mean of its texture and the mean of the mesh's
    /// vertex colours.
    #[default]
    Mean,
    /// 0.5 for every surface; only the emission is taken from the material.
    Neutral,
    /// Albedo reprojected from the G-buffers of cameras, textures included, where a surface is visible.
    /// Surfaces that are not visible keep the albedo that was reprojected before, or else use
    /// [`Mean`](Self::Mean). Cameras need `DepthPrepass` and `DeferredPrepass`, and materials must be
    /// rendered deferred. It takes 24 bytes per voxel. Moving the volume clears the reprojected albedo.
    Reprojected,
}

/// How a pixel samples the voxels around it.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Receiver {
    /// A weighted mean of all eight voxels: three filtered texture reads. At the foot of a wall thinner
    /// than a voxel, light leaks from the other side.
    #[default]
    Interpolated,
    /// Only those of the eight voxels that are visible from the pixel, tested with a short ray to each
    /// through the sub-voxels: such leaks fall from half of the light to a few percent. Right beside
    /// small things that stand on a surface, its light has patches with hard edges. It takes 16 more
    /// bytes per voxel, up to 24 unfiltered reads, and about 50 reads of sub-voxels. When the first volume
    /// begins or ceases to use it, a frame waits until the shaders of all materials are compiled again.
    PerPixel,
}

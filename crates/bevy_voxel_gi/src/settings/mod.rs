//! All that a user sets. Each type with a range has `clamped`, which brings it into its range.

mod light;
mod volume;

use bevy::prelude::*;

pub use light::{Bounces, Sky, Solver, VoxelLight};
pub use volume::{Follow, FollowTemplate, VoxelGiVolume, VoxelGiVolumeTemplate};

/// The settings that all [`VoxelGiVolume`]s of an app share: what is computed, and how exactly.
///
/// [`VoxelGiPlugin`](crate::VoxelGiPlugin) adds this resource with its defaults. A change counts from the next frame on.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct VoxelGiSettings {
    /// Number of voxels along an edge of each cube, 8 to 128, a multiple of 4. Default 32. Memory grows with the cube
    /// of this number; see [`VoxelGiReport::memory`](crate::VoxelGiReport::memory). Where the device cannot
    /// bind buffers of that size, the number is lower, and a warning says so.
    #[reflect(@8..=128_u32)]
    pub resolution: u32,
    /// The light that is computed: global illumination or ambient occlusion. Default: global illumination by 32 rays
    /// from each surface, reflected endlessly.
    pub light: VoxelLight,
    /// The algorithm that converts meshes to voxels. Default [`Conservative`](Voxelizer::Conservative).
    pub voxelizer: Voxelizer,
    /// The source of the diffuse reflectance of surfaces. Default [`Material`](VoxelAlbedo::Material).
    pub albedo: VoxelAlbedo,
    /// How a pixel samples the voxels around it. Default [`Interpolated`](Receiver::Interpolated).
    pub receiver: Receiver,
    /// Whether rough surfaces have specular light of the volume, too. Those of a perceptual roughness of 0.4 and more
    /// reflect what the voxels see in the mirror's direction, in place of environment maps, whose light shines through
    /// walls, and of reflection probes. From 0.4 down to 0.3 it fades into theirs. Default `false`: diffuse light only.
    ///
    /// It takes nine more filtered reads of a pixel, and no memory. Reflections are blurred over several voxels, bounces stay
    /// diffuse, and beside walls thinner than two or three voxels there are spots of what is behind them. Pixels of
    /// `ScreenSpaceReflections` keep the environment map. When this changes, a frame waits until the shaders of all
    /// materials are compiled again.
    pub specular_light: bool,
    /// Number of points of a voxel's surface that are tested for shadow, per light, 1 to 16. Default 16.
    /// Lower values cost less and make the edges of shadows coarser.
    #[reflect(@1..=16_u32)]
    pub shadow_samples: u32,
    /// Updates one n-th of each volume per frame, 1 to 16 (thesis section 6.9.1). Default 1: all of it is
    /// updated in each frame. Higher values cost less per frame and respond to changes later;
    /// direct light is still computed for the whole volume each frame.
    #[reflect(@1..=16_u32)]
    pub update_interval: u32,
    /// Whether the computation stops once nothing has moved or changed for as long as the light needs
    /// to settle. Default `true`.
    pub pause_when_settled: bool,
    /// Whether meshes with a `Lightmap` receive the light, too. Default `false`: it is in their lightmaps already.
    /// With `true` they receive all of it, which is right where lightmaps have direct light only.
    pub affects_lightmapped_meshes: bool,
}

impl Default for VoxelGiSettings {
    fn default() -> Self {
        Self {
            resolution: 32,
            light: VoxelLight::default(),
            voxelizer: Voxelizer::default(),
            albedo: VoxelAlbedo::default(),
            receiver: Receiver::default(),
            specular_light: false,
            shadow_samples: 16,
            update_interval: 1,
            pause_when_settled: true,
            affects_lightmapped_meshes: false,
        }
    }
}

impl VoxelGiSettings {
    /// Returns a copy with every field clamped to its range.
    pub fn clamped(&self) -> Self {
        Self {
            resolution: (self.resolution / 4 * 4).clamp(8, 128),
            light: self.light.clamped(),
            voxelizer: self.voxelizer.clamped(),
            shadow_samples: self.shadow_samples.clamp(1, 16),
            update_interval: self.update_interval.clamp(1, 16),
            ..self.clone()
        }
    }
}

/// The algorithm that converts meshes to voxels.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
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
        #[reflect(@1..=1024_u32)]
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
#[non_exhaustive]
pub enum VoxelAlbedo {
    /// That of the materials in each face of a voxel, by their area there: base colour times texture and vertex
    /// colours, less what is metallic.
    #[default]
    Material,
    /// 0.5 for every surface; only the emission is taken from the material.
    Neutral,
    /// Albedo reprojected from the G-buffers of cameras, textures included, where a surface is visible.
    /// Surfaces that are not visible keep the albedo that was reprojected before, or else use
    /// [`Material`](Self::Material). Cameras need `DepthPrepass` and `DeferredPrepass`, and materials must be
    /// rendered deferred. It takes 24 bytes per voxel. Moving the volume clears the reprojected albedo.
    Reprojected,
}

/// How a pixel samples the voxels around it.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Receiver {
    /// A weighted mean of those of the eight voxels that are on the pixel's side of walls and floors: three
    /// filtered texture reads, and one of what divides the voxels. Along the axes, walls may be as thin as
    /// they are; at the foot of a turned wall thinner than a voxel, light leaks from the other side.
    #[default]
    Interpolated,
    /// Only those of the eight voxels that are visible from the pixel, tested with a short ray to each
    /// through the sub-voxels: beside turned walls and what is small, leaks fall from half of the light to a
    /// few percent. Right beside small things that stand on a surface, its light has patches with hard
    /// edges. It takes 8 more bytes per voxel, up to 24 unfiltered reads, and about 50 reads of sub-voxels.
    /// When this changes, a frame waits until the shaders of all materials are compiled again.
    PerPixel,
}

/// Limits the GPU time that the light of all volumes takes per frame, while this resource is there.
///
/// While the app runs, the most accurate setting that fits is chosen from GPU timestamps: the number of
/// rays of [`Trace`](crate::Solver::Trace) and of ambient occlusion, or of iterations of
/// [`Propagate`](crate::Solver::Propagate), and where the fewest are too many, the fraction of the volume
/// that is updated per frame. The values of these in [`VoxelGiSettings`] are ignored; resolution, solver and
/// bounces are not changed.
///
/// Needs [`VoxelGiBudgetPlugin`](crate::VoxelGiBudgetPlugin) and an adapter with timestamp queries (`TIMESTAMP_QUERY`: Vulkan and
/// DirectX 12). Without them, a warning is logged and the settings are used as they are. A budget below
/// the time of the cheapest setting is exceeded.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct VoxelGiBudget {
    /// GPU time in milliseconds per frame, above 0. Default 2.
    pub milliseconds: f32,
}

impl Default for VoxelGiBudget {
    fn default() -> Self {
        Self { milliseconds: 2.0 }
    }
}

impl VoxelGiBudget {
    /// Returns a copy with the budget clamped to its range.
    pub fn clamped(self) -> Self {
        Self {
            milliseconds: self.milliseconds.max(0.0),
        }
    }
}

/// Excludes a mesh from voxelisation: it does not block or reflect light, though it still receives it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct NotVoxelized;

/// Overrides the [`VoxelMaterial`](crate::VoxelMaterial) that a mesh gets from its material.
///
/// This is for custom shaders, and for what should give another light than it shows. Transparency remains that of the
/// material; a material without a
/// [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin) is opaque and emits nothing unless it is said here.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone)]
pub struct MeshVoxelMaterial {
    /// Diffuse reflectance of all of the mesh, linear, 0 to 1. Default `None`: the material's.
    pub albedo: Option<Vec3>,
    /// Opaque fraction of its area, 0 to 1: below 1 where an alpha mask cuts holes. Default `None`: the
    /// material's.
    pub coverage: Option<f32>,
    /// Emission of all of the mesh, in the units of `StandardMaterial::emissive` and with the material's
    /// `emissive_exposure_weight`. Default `None`: the material's.
    pub emissive: Option<LinearRgba>,
    /// Factor of what the mesh emits into volumes, at least 0; its own picture is as before. Default `None`: 1.
    pub emission_factor: Option<f32>,
}

/// How much a light gives to volumes: on a `PointLight`, `SpotLight`, `DirectionalLight` or `RectLight`. What it lights
/// directly is as before.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
pub struct VoxelGiLight {
    /// Factor of its light in volumes, at least 0. Default 1, which is physically correct; with 0, it has no bounce and
    /// costs nothing.
    pub factor: f32,
}

impl Default for VoxelGiLight {
    fn default() -> Self {
        Self { factor: 1.0 }
    }
}

/// Returns a value within its range, or `otherwise` if it is not finite.
fn clamped_or(value: f32, least: f32, most: f32, otherwise: f32) -> f32 {
    if value.is_finite() {
        value.clamp(least, most)
    } else {
        otherwise
    }
}

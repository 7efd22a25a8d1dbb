//! What a user chooses.

use bevy::prelude::*;

/// A cube of the world in which light bounces.
///
/// Everything with a `Mesh3d` in the cube is voxelised each frame, whether a camera sees it or not,
/// and every material with Bevy's lighting in the cube receives what bounces, without a change.
/// The cube lies around the entity's position; rotation and scale of the entity are not used.
/// Several volumes may be there, beside or in each other: a pixel is lit by the smallest that holds
/// it, and rays that leave a volume go on in a larger one that is there, around it or adjoining;
/// elsewhere they see the sky of the volume that they have left. They share all settings of the one
/// spawned first but [`size`](Self::size), [`cascades`](Self::cascades), [`follow`](Self::follow),
/// [`sky`](Self::sky) and [`intensity`](Self::intensity), and there are at most eight cubes: volumes
/// times their cascades. What exceeds this is left out with a warning.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
#[require(Transform)]
pub struct VoxelGiVolume {
    /// Edge of the cube in metres, above 0. Default 16. With [`cascades`](Self::cascades) the
    /// edge of the smallest.
    pub size: f32,
    /// Voxels along an edge, 8 to 128, a multiple of 4. Default 32. Memory grows with its cube;
    /// see [`VoxelGiReport::memory`](crate::VoxelGiReport::memory).
    pub resolution: u32,
    /// What is computed.
    pub light: VoxelLight,
    /// How meshes become voxels.
    pub voxelizer: Voxelizer,
    /// What is taken for the diffuse reflectance of surfaces.
    pub albedo: VoxelAlbedo,
    /// How a pixel reads the voxels around it.
    pub receiver: Receiver,
    /// The light that comes from outside the volume.
    pub sky: Sky,
    /// Points of a voxel's surface that are tested for shadow, per light, 1 to 16. Default 16.
    pub shadow_samples: u32,
    /// Concentric cubes, each twice as large as the one before, all of the same resolution:
    /// 1 to 4. Default 1.
    pub cascades: u32,
    /// Follows this entity, the camera say, in steps of whole voxels of the largest cascade.
    /// Default none: the volume stays.
    pub follow: Option<Entity>,
    /// Renews every this many frames a part of the volume, 1 to 16 (thesis section 6.9.1).
    /// Default 1: all of it each frame. Fewer rays each frame, and latency in proportion; lamps
    /// light all of it each frame.
    pub update_interval: u32,
    /// Stops computing once nothing has moved or changed for as long as the light needs to
    /// settle. Default on.
    pub pause_when_settled: bool,
    /// Factor of the light that reaches the image. Default 1: as physics has it.
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
            intensity: 1.0,
        }
    }
}

impl VoxelGiVolume {
    /// A copy whose every field is in its range.
    pub fn clamped(&self) -> Self {
        let finite = |value: f32, least: f32, most: f32, otherwise: f32| {
            if value.is_finite() {
                value.clamp(least, most)
            } else {
                otherwise
            }
        };
        Self {
            size: finite(self.size, 1e-3, 1e6, 16.0),
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
            intensity: finite(self.intensity, 0.0, 1e4, 1.0),
        }
    }

    /// Edge of a voxel of the smallest cascade in metres.
    pub fn voxel_size(&self) -> f32 {
        self.size / self.resolution as f32
    }
}

/// What a volume computes.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum VoxelLight {
    /// Light that surfaces reflect, emit and receive from the sky.
    GlobalIllumination {
        /// How light gets from surface to surface.
        solver: Solver,
        /// How often it is reflected.
        bounces: Bounces,
    },
    /// The sky's light alone, less where surfaces nearby are in its way (thesis section 6.7):
    /// neither materials nor lamps are looked at, nor is memory taken for them.
    AmbientOcclusion {
        /// Surfaces further away than this do not occlude, in metres, above 0.
        radius: f32,
        /// Rays from each side of a voxel, 16 to 256, a multiple of 16.
        rays: u32,
    },
}

impl Default for VoxelLight {
    fn default() -> Self {
        Self::GlobalIllumination {
            solver: Solver::default(),
            bounces: Bounces::default(),
        }
    }
}

impl VoxelLight {
    fn clamped(self) -> Self {
        match self {
            Self::GlobalIllumination { solver, bounces } => Self::GlobalIllumination {
                solver: match solver {
                    Solver::March { rays } => Solver::March {
                        rays: (rays / 4 * 4).clamp(4, 256),
                    },
                    Solver::Propagate { iterations } => Solver::Propagate {
                        iterations: iterations.clamp(1, 512),
                    },
                },
                bounces: match bounces {
                    Bounces::Count(count) => Bounces::Count(count.clamp(1, 8)),
                    Bounces::Endless => Bounces::Endless,
                },
            },
            Self::AmbientOcclusion { radius, rays } => Self::AmbientOcclusion {
                radius: if radius.is_finite() {
                    radius.max(0.0)
                } else {
                    1.0
                },
                rays: rays.clamp(16, 256).next_multiple_of(16),
            },
        }
    }
}

/// How light gets from surface to surface.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// Rays from every surface through the voxels (thesis section 6.6.1).
    March {
        /// Rays from each side of a voxel that has a surface, 4 to 256, a multiple of 4. Default
        /// 32. Each frame has others, and pixels see a mean of eight frames.
        rays: u32,
    },
    /// From voxel to voxel in second-order spherical harmonics (thesis section 6.6.2). Smooth and
    /// cheap per step, but light spreads as it goes. Bounces are part of the steps:
    /// [`Bounces`] does not matter. One cascade only.
    Propagate {
        /// Steps, 1 to 512; light goes one voxel a step.
        iterations: u32,
    },
}

impl Default for Solver {
    fn default() -> Self {
        Self::March { rays: 32 }
    }
}

/// How often light is reflected before it arrives.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounces {
    /// This often, 1 to 8, all computed in each frame: no latency, at a multiple of the cost.
    Count(u32),
    /// Once a frame, from what the former frame left: after some frames, endlessly often.
    #[default]
    Endless,
}

/// How meshes become voxels.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Voxelizer {
    /// Every voxel that a triangle touches, without holes.
    #[default]
    Conservative,
    /// Thesis section 6.4.2, fragment clipping: triangles are rasterised for each slice that they
    /// span, what lies outside of the slice is dropped. Sampled, not conservative.
    FragmentClipping,
    /// Thesis section 6.4.2, geometry clipping: triangles are cut into slices first, then
    /// rasterised. The same voxels at another cost.
    GeometryClipping,
    /// Thesis section 6.4.3: random points on each triangle. Large triangles get holes.
    Stochastic {
        /// Points on each triangle, 1 to 1024.
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

/// What is taken for the diffuse reflectance of surfaces (thesis section 6.5.2).
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VoxelAlbedo {
    /// Of each material one colour: that of the material times the mean of its texture, and of the
    /// mesh's vertex colours.
    #[default]
    Mean,
    /// 0.5 everywhere; only emission is the material's.
    Neutral,
    /// Where a camera sees a surface, what it sees there, texture and all; elsewhere what one has
    /// seen of the surface before, or else [`Mean`](Self::Mean). Cameras need `DepthPrepass` and
    /// `DeferredPrepass`, and materials to be deferred. For 24 bytes a voxel. A volume that moves
    /// forgets what was seen.
    Seen,
}

/// How a pixel reads the voxels around it.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Receiver {
    /// A weighted mean of all eight: three filtered texture reads. At the foot of a wall thinner
    /// than a voxel light of the other side leaks.
    #[default]
    Interpolated,
    /// Of the eight those that the pixel sees, by a short ray to each through the sub-voxels: such
    /// leaks fall from half of the light to a few percent. Right beside small things that
    /// stand on a surface its light has patches with hard edges. For 16 bytes a voxel more, up to 24
    /// unfiltered reads, and some 50 of sub-voxels.
    PerPixel,
}

/// The light from outside of the volume: radiance in cd/m². Default: none.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default)]
pub struct Sky {
    /// From above.
    pub zenith: LinearRgba,
    /// From the horizon.
    pub horizon: LinearRgba,
    /// From below.
    pub ground: LinearRgba,
}

impl Default for Sky {
    fn default() -> Self {
        // A colour's default is white.
        Self::uniform(LinearRgba::BLACK)
    }
}

impl Sky {
    /// The same radiance from everywhere, in cd/m².
    pub const fn uniform(radiance: LinearRgba) -> Self {
        Self {
            zenith: radiance,
            horizon: radiance,
            ground: radiance,
        }
    }

    fn clamped(self) -> Self {
        let clamped = |color: LinearRgba| {
            let channel = |value: f32| {
                if value.is_finite() {
                    value.max(0.0)
                } else {
                    0.0
                }
            };
            LinearRgba::rgb(
                channel(color.red),
                channel(color.green),
                channel(color.blue),
            )
        };
        Self {
            zenith: clamped(self.zenith),
            horizon: clamped(self.horizon),
            ground: clamped(self.ground),
        }
    }
}

/// On a mesh: it is no obstacle to light and reflects none, though it still receives it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct NotVoxelized;

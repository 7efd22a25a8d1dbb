//! The light that a volume computes, and how; and the light from outside of it.

use bevy::prelude::*;

use super::clamped_or;

/// The light that a volume computes.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum VoxelLight {
    /// The light that surfaces reflect, emit and receive from the sky.
    GlobalIllumination {
        /// How light is transported from surface to surface.
        solver: Solver,
        /// The number of times that light is reflected.
        bounces: Bounces,
    },
    /// Only the sky's light, reduced where surfaces nearby occlude it (thesis section 6.7). Materials
    /// and lights are not evaluated.
    AmbientOcclusion {
        /// Surfaces further away than this do not occlude, in metres, at least 0.
        radius: f32,
        /// Number of rays from each side of a voxel that has a surface, 4 to 256, a multiple of 4, as of
        /// [`Solver::Trace`]. Pixels read a mean over frames as there, so 16 are enough: the light differs from that of
        /// many rays by 0.3 to 0.6% once it has settled, and by 0.5 to 0.9% while things move.
        #[reflect(@4..=256_u32)]
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
    pub(crate) fn propagates(self) -> bool {
        let Self::GlobalIllumination { solver, .. } = self else {
            return false;
        };
        matches!(solver, Solver::Propagate { .. })
    }

    /// Returns the same light with another number of rays or iterations.
    pub(crate) fn with_work(self, work: u32) -> Self {
        match self {
            Self::GlobalIllumination { solver, bounces } => Self::GlobalIllumination {
                solver: match solver {
                    Solver::Trace { .. } => Solver::Trace { rays: work },
                    Solver::Propagate { .. } => Solver::Propagate { iterations: work },
                },
                bounces,
            },
            Self::AmbientOcclusion { radius, .. } => Self::AmbientOcclusion { radius, rays: work },
        }
    }

    pub(crate) fn is_occlusion(self) -> bool {
        matches!(self, Self::AmbientOcclusion { .. })
    }

    pub(super) fn clamped(self) -> Self {
        match self {
            Self::GlobalIllumination { solver, bounces } => Self::GlobalIllumination {
                solver: match solver {
                    Solver::Trace { rays } => Solver::Trace {
                        rays: clamped_rays(rays),
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
                radius: clamped_or(radius, 0.0, f32::MAX, 1.0),
                rays: clamped_rays(rays),
            },
        }
    }
}

/// As many rays start at each of four points of a surface.
fn clamped_rays(rays: u32) -> u32 {
    (rays / 4 * 4).clamp(4, 256)
}

/// How light is transported from surface to surface.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// Ray tracing from every surface through the voxels (thesis section 6.6.1).
    Trace {
        /// Number of rays from each side of a voxel that has a surface, 4 to 256, a multiple of 4.
        /// Default 32. More rays cost more time and give less noise. Each frame uses different rays, and
        /// pixels read a mean over frames: eight while things change, all of them since the change
        /// afterwards.
        #[reflect(@4..=256_u32)]
        rays: u32,
    },
    /// Propagation from voxel to voxel in second-order spherical harmonics (thesis section 6.6.2), for comparison with
    /// the thesis. It has neither noise nor latency, as all light of a frame is computed in it, but light spreads as
    /// it travels: on the scenes of its study, its error is three to five times that of [`Solver::Trace`] with 8 rays
    /// and 16³ voxels, which takes less time. Bounces are part of the steps, so [`Bounces`] is ignored. It supports one
    /// cascade only.
    Propagate {
        /// Number of steps, 1 to 512. Light travels one voxel per step: twice the [resolution] takes it through most
        /// scenes.
        ///
        /// [resolution]: crate::VoxelGiSettings::resolution
        #[reflect(@1..=512_u32)]
        iterations: u32,
    },
}

impl Default for Solver {
    fn default() -> Self {
        Self::Trace { rays: 32 }
    }
}

/// The number of times that light is reflected before it reaches a pixel.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounces {
    /// This many reflections, 1 to 8, all computed in each frame: no latency, at a multiple of the cost.
    Count(#[reflect(@1..=8_u32)] u32),
    /// One reflection per frame of the light that the previous frame left: over several frames, the
    /// light of infinitely many bounces.
    #[default]
    Endless,
}

/// The light from outside of the volume: radiance in cd/m². Default: black.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default)]
pub struct Sky {
    /// Radiance from straight above (+Y).
    pub zenith: LinearRgba,
    /// Radiance from the horizon.
    pub horizon: LinearRgba,
    /// Radiance from straight below (-Y).
    pub ground: LinearRgba,
}

impl Default for Sky {
    fn default() -> Self {
        // The default of `LinearRgba` is white.
        Self::uniform(LinearRgba::BLACK)
    }
}

impl Sky {
    /// Creates a sky with the same radiance in all directions, in cd/m².
    pub const fn uniform(radiance: LinearRgba) -> Self {
        Self {
            zenith: radiance,
            horizon: radiance,
            ground: radiance,
        }
    }

    pub(crate) fn clamped(self) -> Self {
        let clamped = |color: LinearRgba| {
            let channel = |value: f32| clamped_or(value, 0.0, f32::MAX, 0.0);
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

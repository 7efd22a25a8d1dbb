//! The quality levels among which a budget chooses, the cheapest first.

use bevy::reflect::Reflect;

use crate::settings::{Solver, VoxelGiSettings, VoxelLight};

/// The settings that a budget changes.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub(crate) struct QualitySettings {
    /// The light, with another number of rays or iterations.
    pub light: VoxelLight,
    /// See [`VoxelGiSettings::update_interval`].
    pub update_interval: u32,
}

impl QualitySettings {
    /// Relative cost of a frame.
    pub(super) fn cost(&self) -> f64 {
        let work = match self.light {
            VoxelLight::GlobalIllumination { solver, .. } => match solver {
                Solver::Trace { rays } => rays,
                Solver::Propagate { iterations } => iterations,
            },
            VoxelLight::AmbientOcclusion { rays, .. } => rays,
        };
        f64::from(work) / f64::from(self.update_interval)
    }

    /// Returns the settings with these applied.
    pub(crate) fn applied(self, settings: &VoxelGiSettings) -> VoxelGiSettings {
        VoxelGiSettings {
            light: self.light,
            update_interval: self.update_interval,
            ..settings.clone()
        }
    }
}

/// Returns the quality levels for this kind of light: the number of rays is reduced first, then the
/// fraction of the volume that a frame updates.
pub(super) fn quality_levels(light: VoxelLight) -> Vec<QualitySettings> {
    let every = |light: VoxelLight| QualitySettings {
        light,
        update_interval: 1,
    };
    let parts = |light: VoxelLight| {
        [16, 8, 4, 2].map(|update_interval| QualitySettings {
            light,
            update_interval,
        })
    };
    let traced = |with: &dyn Fn(u32) -> VoxelLight| {
        let all = [8, 16, 32, 64, 128, 256].map(|rays| every(with(rays)));
        parts(with(8)).into_iter().chain(all).collect()
    };
    match light {
        VoxelLight::GlobalIllumination {
            solver: Solver::Trace { .. },
            bounces,
        } => traced(&|rays| VoxelLight::GlobalIllumination {
            solver: Solver::Trace { rays },
            bounces,
        }),
        VoxelLight::AmbientOcclusion { radius, .. } => {
            traced(&|rays| VoxelLight::AmbientOcclusion { radius, rays })
        }
        // Propagation starts over in each frame, so it cannot update only a part of the volume.
        VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { .. },
            bounces,
        } => [8, 16, 32, 48, 64, 96, 128]
            .map(|iterations| {
                every(VoxelLight::GlobalIllumination {
                    solver: Solver::Propagate { iterations },
                    bounces,
                })
            })
            .to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Bounces;

    #[test]
    fn ladders_ascend_and_are_in_range() {
        let bounces = Bounces::default();
        for light in [
            VoxelLight::default(),
            VoxelLight::GlobalIllumination {
                solver: Solver::Propagate { iterations: 9 },
                bounces,
            },
            VoxelLight::AmbientOcclusion {
                radius: 1.0,
                rays: 64,
            },
        ] {
            let quality_levels = quality_levels(light);
            assert!(
                quality_levels.is_sorted_by(|a, b| a.cost() < b.cost()),
                "{quality_levels:?}"
            );
            for chosen in quality_levels {
                let settings = chosen.applied(&VoxelGiSettings::default());
                assert_eq!(settings, settings.clamped());
            }
        }
    }
}

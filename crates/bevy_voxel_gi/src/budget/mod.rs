//! Chooses the most accurate light that fits into a time budget.

mod controller;

use bevy::{
    diagnostic::{DiagnosticMeasurement, DiagnosticsStore},
    platform::time::Instant,
    prelude::*,
    render::{renderer::RenderDevice, settings::WgpuFeatures},
};

use crate::settings::{Solver, VoxelGiBudget, VoxelGiSettings, VoxelLight};
use controller::Controller;

/// The settings that the budget has chosen.
#[derive(Resource, Reflect, Default)]
#[reflect(Resource, Default)]
pub struct BudgetChoice {
    chosen: Option<QualitySettings>,
    #[reflect(ignore)]
    controller: Controller,
    /// The cheapest light for which the quality levels were built; a different one means a new solver.
    #[reflect(ignore)]
    kind: Option<VoxelLight>,
    /// Time of the newest measurement that has been read.
    #[reflect(ignore)]
    newest: Option<Instant>,
}

impl BudgetChoice {
    pub(crate) fn chosen(&self) -> Option<QualitySettings> {
        self.chosen
    }

    /// The index of the chosen quality level, 0 for the cheapest, and the number of levels; `None`
    /// without a budget.
    pub fn quality_level(&self) -> Option<(usize, usize)> {
        self.chosen
            .map(|_| (self.controller.level(), self.controller.len()))
    }

    /// The chosen light and [`update_interval`](VoxelGiSettings::update_interval) (every n-th slice is
    /// updated in a frame); `None` without a budget.
    pub fn settings(&self) -> Option<(VoxelLight, u32)> {
        self.chosen
            .map(|chosen| (chosen.light, chosen.update_interval))
    }
}

pub(crate) fn choose_quality(
    mut choice: ResMut<BudgetChoice>,
    settings: Res<VoxelGiSettings>,
    budget: Option<Res<VoxelGiBudget>>,
    store: Option<Res<DiagnosticsStore>>,
    device: Option<Res<RenderDevice>>,
) {
    let Some(budget) = budget else {
        if choice.chosen.is_some() {
            *choice = BudgetChoice::default();
        }
        return;
    };
    let has_timestamps =
        device.is_some_and(|device| device.features().contains(WgpuFeatures::TIMESTAMP_QUERY));
    let Some(store) = store.filter(|_| has_timestamps) else {
        warn_once!(
            "voxel GI: a `VoxelGiBudget` needs Bevy's `DiagnosticsPlugin` and an adapter with \
             timestamp queries (`TIMESTAMP_QUERY`); the settings are used as they are"
        );
        return;
    };
    let choice = &mut *choice;
    let settings = settings.clamped();
    let levels = quality_levels(settings.light);
    let kind = levels.first().map(|chosen| chosen.light);
    if choice.kind != kind {
        // Start at the level nearest to the app's own settings.
        let own = QualitySettings {
            light: settings.light,
            update_interval: settings.update_interval,
        };
        let start = levels.partition_point(|level| level.cost() < own.cost());
        choice.controller = Controller::new(levels.iter().map(QualitySettings::cost), start);
        choice.kind = kind;
    }
    if let Some(milliseconds) = new_time(&store, &mut choice.newest) {
        choice
            .controller
            .frame(milliseconds, f64::from(budget.clamped().milliseconds));
    }
    choice.chosen = levels.get(choice.controller.level()).copied();
}

/// Mean GPU time per frame of the volume over the measurements that have not been read yet, if any.
fn new_time(store: &DiagnosticsStore, known: &mut Option<Instant>) -> Option<f64> {
    let (mut sum, mut frames, mut newest) = (0.0, 0, *known);
    for diagnostic in store.iter() {
        let components: Vec<_> = diagnostic.path().components().collect();
        let ["render", name, "elapsed_gpu"] = components[..] else {
            continue;
        };
        if !name.starts_with("voxel_gi_") {
            continue;
        }
        let is_new =
            |measured: &&DiagnosticMeasurement| known.is_none_or(|known| measured.time > known);
        for measured in diagnostic.measurements().filter(is_new) {
            sum += measured.value;
            // This pass runs once per frame, so its measurements count the frames.
            frames += u32::from(name == "voxel_gi_compact");
            newest = newest.max(Some(measured.time));
        }
    }
    *known = newest;
    (frames > 0).then(|| sum / f64::from(frames))
}

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
    fn cost(&self) -> f64 {
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
fn quality_levels(light: VoxelLight) -> Vec<QualitySettings> {
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

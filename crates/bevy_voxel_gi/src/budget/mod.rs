//! Chooses the most accurate light that fits into a time budget.

mod controller;
mod quality_levels;

use bevy::{
    diagnostic::{DiagnosticMeasurement, DiagnosticsStore},
    platform::time::Instant,
    prelude::*,
    render::{renderer::RenderDevice, settings::WgpuFeatures},
};

use self::{
    controller::Controller,
    quality_levels::{QualitySettings, quality_levels},
};
use crate::settings::{VoxelGiBudget, VoxelGiSettings, VoxelLight};

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

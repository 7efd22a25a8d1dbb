//! The most accurate light that fits into a time.

mod controller;
mod ladder;

use bevy::{
    diagnostic::{DiagnosticMeasurement, DiagnosticsStore},
    platform::time::Instant,
    prelude::*,
    render::{diagnostic::RenderDiagnosticsPlugin, renderer::RenderDevice, settings::WgpuFeatures},
};

use self::{controller::Controller, ladder::ladder};
use crate::{
    settings::{VoxelGiVolume, VoxelLight},
    volume::placement::place_volume,
};

pub(crate) use self::ladder::Chosen;

/// On the first [`VoxelGiVolume`]: its light may take this long a frame.
///
/// From the times that the GPU measures, the most accurate setting that fits is chosen while the
/// game runs: rays of [`March`](crate::Solver::March) and of ambient occlusion, iterations of
/// [`Propagate`](crate::Solver::Propagate), and where the fewest are too many, the part of the
/// volume that is renewed in a frame. What the volume's own settings say of these does not count;
/// resolution, solver and bounces stay as they are.
///
/// Needs [`VoxelGiBudgetPlugin`] and an adapter with time stamps (`TIMESTAMP_QUERY`: Vulkan and
/// DirectX 12). Without, a warning says so and the volume's own settings count. A time below that
/// of the cheapest setting is exceeded.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
pub struct VoxelGiBudget {
    /// Time on the GPU in milliseconds a frame, above 0. Default 2.
    pub milliseconds: f32,
}

impl Default for VoxelGiBudget {
    fn default() -> Self {
        Self { milliseconds: 2.0 }
    }
}

/// Lets volumes have a [`VoxelGiBudget`].
///
/// It adds Bevy's `RenderDiagnosticsPlugin`, whose time stamps it reads, unless that is there
/// already: add that one before if you add it yourself.
#[derive(Clone, Copy, Debug, Default)]
pub struct VoxelGiBudgetPlugin;

impl Plugin for VoxelGiBudgetPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<RenderDiagnosticsPlugin>() {
            app.add_plugins(RenderDiagnosticsPlugin);
        }
        app.register_type::<VoxelGiBudget>()
            .init_resource::<BudgetChoice>()
            .add_systems(PostUpdate, choose.before(place_volume));
    }
}

/// What the budget has chosen for the first volume.
#[derive(Resource, Default)]
pub struct BudgetChoice {
    chosen: Option<Chosen>,
    controller: Controller,
    /// For which the ladder was made.
    kind: Option<VoxelLight>,
    /// Times up to this one are known.
    known: Option<Instant>,
}

impl BudgetChoice {
    pub(crate) fn chosen(&self) -> Option<Chosen> {
        self.chosen
    }

    /// The chosen rung, 0 for the cheapest, and how many there are; `None` without a budget.
    pub fn rung(&self) -> Option<(usize, usize)> {
        self.chosen
            .map(|_| (self.controller.rung(), self.controller.len()))
    }

    /// Light and part of the volume a frame (every so many-th slice) that are chosen; `None`
    /// without a budget.
    pub fn settings(&self) -> Option<(VoxelLight, u32)> {
        self.chosen
            .map(|chosen| (chosen.light, chosen.update_interval))
    }
}

fn choose(
    mut choice: ResMut<BudgetChoice>,
    volumes: Query<(&VoxelGiVolume, &VoxelGiBudget)>,
    store: Option<Res<DiagnosticsStore>>,
    device: Option<Res<RenderDevice>>,
) {
    let Some((volume, budget)) = volumes.iter().next() else {
        if choice.chosen.is_some() {
            *choice = BudgetChoice::default();
        }
        return;
    };
    let has_stamps =
        device.is_some_and(|device| device.features().contains(WgpuFeatures::TIMESTAMP_QUERY));
    let Some(store) = store.filter(|_| has_stamps) else {
        warn_once!(
            "voxel GI: a `VoxelGiBudget` needs Bevy's `DiagnosticsPlugin` and an adapter with \
             time stamps (TIMESTAMP_QUERY); the volume's own settings are used"
        );
        return;
    };
    let choice = &mut *choice;
    let rungs = ladder(volume.clamped().light);
    let kind = rungs.first().map(|chosen| chosen.light);
    if choice.kind != kind {
        // From the volume's own settings on.
        let own = Chosen {
            light: volume.clamped().light,
            update_interval: volume.clamped().update_interval,
        };
        let start = rungs.partition_point(|rung| rung.cost() < own.cost());
        choice.controller = Controller::new(rungs.iter().map(Chosen::cost), start);
        choice.kind = kind;
    }
    if let Some(milliseconds) = new_time(&store, &mut choice.known) {
        choice
            .controller
            .frame(milliseconds, f64::from(budget.milliseconds.max(0.0)));
    }
    choice.chosen = rungs.get(choice.controller.rung()).copied();
}

/// Time of a frame of the volume, if one has come in that is not known yet; the mean of several.
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
            // Once a frame.
            frames += u32::from(name == "voxel_gi_list");
            newest = newest.max(Some(measured.time));
        }
    }
    *known = newest;
    (frames > 0).then(|| sum / f64::from(frames))
}

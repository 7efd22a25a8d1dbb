//! Chooses the most accurate light that fits into a time budget.

use bevy::{
    diagnostic::{DiagnosticMeasurement, DiagnosticsStore},
    platform::time::Instant,
    prelude::*,
    render::{renderer::RenderDevice, settings::WgpuFeatures},
};

use crate::settings::{Solver, VoxelGiBudget, VoxelGiSettings, VoxelLight};

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
    let level = |work, update_interval| QualitySettings {
        light: light.with_work(work),
        update_interval,
    };
    if light.propagates() {
        // Propagation starts over in each frame, so it cannot update only a part of the volume.
        return Vec::from([8, 16, 32, 48, 64, 96, 128].map(|iterations| level(iterations, 1)));
    }
    let parts = [16, 8, 4, 2].map(|interval| level(8, interval));
    let all = [8, 16, 32, 64, 128, 256].map(|rays| level(rays, 1));
    [&parts[..], &all].concat()
}

/// Number of frames over which the median is taken.
const SAMPLES: usize = 8;
/// Number of frames after a step to ignore: GPU times arrive late and still belong to the old level.
const DELAY: u32 = 8;
/// The controller steps up only when the time is below this fraction of the budget.
const ROOM: f64 = 0.8;
/// Number of frames after which a level that was too slow may be tried again; it doubles each further
/// time that the level is too slow.
const PATIENCE: u32 = 240;
const MOST_PATIENCE: u32 = 240 * 64;

/// A quality level and what has been measured of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct QualityLevel {
    /// Relative cost, above 0: only ratios matter, and only as a first estimate.
    cost: f64,
    /// Median time in milliseconds when this was last the current level.
    measured: Option<f64>,
    /// Number of frames until it may be tried again.
    blocked_frames: u32,
    patience: u32,
}

/// Chooses the quality level that fits into a time budget, from measured times alone, with hysteresis.
///
/// Quality levels are sorted by cost, the cheapest first. The controller keeps a current level, takes
/// the median of several frames, and steps down at once when that is above the budget, as far as the
/// nominal costs predict. It steps up only when there is headroom, one level at a time, and a level
/// that was too slow is not tried again for a while, so that the controller does not oscillate.
#[derive(Clone, Debug, Default, PartialEq)]
struct Controller {
    levels: Vec<QualityLevel>,
    at: usize,
    samples: Vec<f64>,
    /// Number of frames still to ignore.
    delay: u32,
    /// The budget of the last frame in milliseconds.
    budget: f64,
}

impl Controller {
    /// Creates a controller for levels of these nominal costs, ascending, with a starting level.
    fn new(costs: impl IntoIterator<Item = f64>, at: usize) -> Self {
        let levels: Vec<_> = costs
            .into_iter()
            .map(|cost| QualityLevel {
                cost,
                patience: PATIENCE,
                ..QualityLevel::default()
            })
            .collect();
        Self {
            at: at.min(levels.len().saturating_sub(1)),
            levels,
            samples: Vec::new(),
            delay: DELAY,
            budget: 0.0,
        }
    }

    fn level(&self) -> usize {
        self.at
    }

    fn len(&self) -> usize {
        self.levels.len()
    }

    /// Adds the time of a frame in milliseconds; returns whether the level has changed.
    fn frame(&mut self, milliseconds: f64, budget: f64) -> bool {
        let is_larger = budget > self.budget;
        self.budget = budget;
        for level in &mut self.levels {
            level.blocked_frames = level.blocked_frames.saturating_sub(1);
            if is_larger {
                (level.blocked_frames, level.patience) = (0, PATIENCE);
            }
        }
        if self.delay > 0 {
            self.delay -= 1;
            return false;
        }
        if !milliseconds.is_finite() || self.levels.is_empty() {
            return false;
        }
        self.samples.push(milliseconds);
        if self.samples.len() < SAMPLES {
            return false;
        }
        self.samples.sort_by(f64::total_cmp);
        let time = self.samples[SAMPLES / 2];
        self.samples.clear();
        self.levels[self.at].measured = Some(time);
        let next = self.next(time, budget);
        let steps = next != self.at;
        if steps {
            self.at = next;
            self.delay = DELAY;
        }
        steps
    }

    fn next(&mut self, time: f64, budget: f64) -> usize {
        if time > budget {
            let here = &mut self.levels[self.at];
            here.blocked_frames = here.patience;
            here.patience = (2 * here.patience).min(MOST_PATIENCE);
            // The most costly lower level that is predicted to fit, else the cheapest.
            let lower = (0..self.at).rev();
            return lower
                .clone()
                .find(|&level| self.expected(level, time) <= budget)
                .unwrap_or(0);
        }
        let above = self.at + 1;
        let may = self
            .levels
            .get(above)
            .is_some_and(|level| level.blocked_frames == 0);
        if may && time < ROOM * budget {
            above
        } else {
            self.at
        }
    }

    /// Predicts the time of another level from that of the current one: by their nominal costs, or by
    /// their measured times where those predict a longer one.
    fn expected(&self, level: usize, time: f64) -> f64 {
        let (to, from) = (&self.levels[level], &self.levels[self.at]);
        let by_cost = time * to.cost / from.cost;
        match (to.measured, from.measured) {
            (Some(before), Some(now)) => by_cost.max(time * before / now.max(1e-9)),
            _ => by_cost,
        }
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

    const COSTS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

    /// Returns the level of each frame on a machine that takes `time` for a cost.
    fn run(
        controller: &mut Controller,
        frames: u32,
        budget: f64,
        time: impl Fn(f64) -> f64,
    ) -> Vec<usize> {
        (0..frames)
            .map(|_| {
                let milliseconds = time(COSTS[controller.level()]);
                controller.frame(milliseconds, budget);
                controller.level()
            })
            .collect()
    }

    #[test]
    fn it_finds_the_most_costly_that_fits_from_either_end() {
        for start in 0..COSTS.len() {
            for (budget, expected) in [(0.5, 0), (1.5, 0), (4.5, 2), (9.0, 3), (100.0, 5)] {
                let mut controller = Controller::new(COSTS, start);
                run(&mut controller, 200, budget, |cost| cost);
                assert_eq!(controller.level(), expected, "{budget} from {start}");
            }
        }
    }

    #[test]
    fn a_constant_part_of_the_time_does_not_mislead_it() {
        // 6, 7, 9, 13, 21, 37 ms.
        let mut controller = Controller::new(COSTS, 5);
        run(&mut controller, 400, 14.0, |cost| 5.0 + cost);
        assert!(
            [2, 3].contains(&controller.level()),
            "{}",
            controller.level()
        );
    }

    #[test]
    fn it_is_quick_to_step_down() {
        let mut controller = Controller::new(COSTS, 5);
        let levels = run(&mut controller, 40, 4.1, |cost| cost);
        assert_eq!(levels[20], 2);
    }

    #[test]
    fn it_does_not_swing() {
        // The next level is above the budget, though its nominal cost says that it fits.
        let mut controller = Controller::new(COSTS, 3);
        run(&mut controller, 300, 11.0, |cost| cost);
        let levels = run(&mut controller, 3000, 11.0, |cost| cost);
        let steps = levels.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(steps <= 8, "{steps}");
        let at_four = levels.iter().filter(|level| **level == 3).count();
        assert!(at_four > 2800, "{at_four}");
    }

    #[test]
    fn single_slow_frames_and_nonsense_do_not_matter() {
        let mut controller = Controller::new(COSTS, 3);
        for frame in 0..500 {
            let milliseconds = match frame % 10 {
                0 => 1e4,
                5 => f64::NAN,
                _ => 8.0,
            };
            controller.frame(milliseconds, 9.0);
            assert_eq!(controller.level(), 3);
        }
    }

    #[test]
    fn a_scene_that_gets_lighter_gets_more() {
        let mut controller = Controller::new(COSTS, 3);
        run(&mut controller, 200, 5.0, |cost| cost);
        assert_eq!(controller.level(), 2);
        run(&mut controller, 3000, 5.0, |cost| 0.1 * cost);
        assert_eq!(controller.level(), 5);
    }
}

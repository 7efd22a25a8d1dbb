//! Chooses the quality level that fits into a time budget, from measured times alone, with hysteresis.
//!
//! Quality levels are sorted by cost, the cheapest first. The controller keeps a current level, takes
//! the median of several frames, and steps down at once when that is above the budget, as far as the
//! nominal costs predict. It steps up only when there is headroom, one level at a time, and a level
//! that was too slow is not tried again for a while, so that the controller does not oscillate.

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

/// Chooses the quality level; see the module documentation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Controller {
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
    pub(super) fn new(costs: impl IntoIterator<Item = f64>, at: usize) -> Self {
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

    /// Index of the current quality level.
    pub(super) fn level(&self) -> usize {
        self.at
    }

    /// Number of quality levels.
    pub(super) fn len(&self) -> usize {
        self.levels.len()
    }

    /// Adds the time of a frame in milliseconds; returns whether the level has changed.
    pub(super) fn frame(&mut self, milliseconds: f64, budget: f64) -> bool {
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

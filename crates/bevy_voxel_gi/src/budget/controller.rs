//! Which of several settings fits into a time: from measured times alone, with hysteresis.
//!
//! Settings are rungs of a ladder, the cheapest first. The controller stands on one of them, takes
//! the median of some frames, and steps down at once when that is above the budget, as far as the
//! nominal costs say. It steps up only when there is room, one rung at a time, and a rung that has
//! turned out too slow is not tried again for a while: it does not swing.

/// Frames of which the median counts.
const SAMPLES: usize = 8;
/// Frames after a step whose times are still those of before: they arrive late.
const DELAY: u32 = 8;
/// Only below this share of the budget is there room for more.
const ROOM: f64 = 0.8;
/// Frames after which a rung that was too slow may be tried again, at first; twice as many each
/// further time.
const PATIENCE: u32 = 240;
const MOST_PATIENCE: u32 = 240 * 64;

/// What is known of a rung.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rung {
    /// Relative cost, above 0: only ratios count, and only as a first guess.
    cost: f64,
    /// Median time when it was stood on last, in milliseconds.
    measured: Option<f64>,
    /// Frames until it may be tried again.
    barred: u32,
    patience: u32,
}

/// See the module.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Controller {
    rungs: Vec<Rung>,
    at: usize,
    samples: Vec<f64>,
    /// Frames whose times do not count.
    delay: u32,
    /// Of the last frame.
    budget: f64,
}

impl Controller {
    /// For rungs of these nominal costs, ascending, standing on one of them.
    pub(super) fn new(costs: impl IntoIterator<Item = f64>, at: usize) -> Self {
        let rungs: Vec<_> = costs
            .into_iter()
            .map(|cost| Rung {
                cost,
                patience: PATIENCE,
                ..Rung::default()
            })
            .collect();
        Self {
            at: at.min(rungs.len().saturating_sub(1)),
            rungs,
            samples: Vec::new(),
            delay: DELAY,
            budget: 0.0,
        }
    }

    /// The rung it stands on.
    pub(super) fn rung(&self) -> usize {
        self.at
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.rungs.len()
    }

    /// Learns the time of a frame in milliseconds; whether it has stepped.
    pub(super) fn frame(&mut self, milliseconds: f64, budget: f64) -> bool {
        let is_larger = budget > self.budget;
        self.budget = budget;
        for rung in &mut self.rungs {
            rung.barred = rung.barred.saturating_sub(1);
            if is_larger {
                (rung.barred, rung.patience) = (0, PATIENCE);
            }
        }
        if self.delay > 0 {
            self.delay -= 1;
            return false;
        }
        if !milliseconds.is_finite() || self.rungs.is_empty() {
            return false;
        }
        self.samples.push(milliseconds);
        if self.samples.len() < SAMPLES {
            return false;
        }
        self.samples.sort_by(f64::total_cmp);
        let time = self.samples[SAMPLES / 2];
        self.samples.clear();
        self.rungs[self.at].measured = Some(time);
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
            let here = &mut self.rungs[self.at];
            here.barred = here.patience;
            here.patience = (2 * here.patience).min(MOST_PATIENCE);
            // The most costly one that may fit, one down at least.
            let lower = (0..self.at).rev();
            return lower
                .clone()
                .find(|&rung| self.expected(rung, time) <= budget)
                .unwrap_or(0);
        }
        let above = self.at + 1;
        let may = self.rungs.get(above).is_some_and(|rung| rung.barred == 0);
        if may && time < ROOM * budget {
            above
        } else {
            self.at
        }
    }

    /// Time of another rung, from that of this one: by their costs, or by their measured times if
    /// those tell of a higher one.
    fn expected(&self, rung: usize, time: f64) -> f64 {
        let (to, from) = (&self.rungs[rung], &self.rungs[self.at]);
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

    /// Rungs over the frames for a machine that takes `time` for a cost.
    fn run(
        controller: &mut Controller,
        frames: u32,
        budget: f64,
        time: impl Fn(f64) -> f64,
    ) -> Vec<usize> {
        (0..frames)
            .map(|_| {
                let milliseconds = time(COSTS[controller.rung()]);
                controller.frame(milliseconds, budget);
                controller.rung()
            })
            .collect()
    }

    #[test]
    fn it_finds_the_most_costly_that_fits_from_either_end() {
        for start in 0..COSTS.len() {
            for (budget, expected) in [(0.5, 0), (1.5, 0), (4.5, 2), (9.0, 3), (100.0, 5)] {
                let mut controller = Controller::new(COSTS, start);
                run(&mut controller, 200, budget, |cost| cost);
                assert_eq!(controller.rung(), expected, "{budget} from {start}");
            }
        }
    }

    #[test]
    fn a_constant_part_of_the_time_does_not_mislead_it() {
        // 6, 7, 9, 13, 21, 37 ms.
        let mut controller = Controller::new(COSTS, 5);
        run(&mut controller, 400, 14.0, |cost| 5.0 + cost);
        assert!([2, 3].contains(&controller.rung()), "{}", controller.rung());
    }

    #[test]
    fn it_is_quick_to_step_down() {
        let mut controller = Controller::new(COSTS, 5);
        let rungs = run(&mut controller, 40, 4.1, |cost| cost);
        assert_eq!(rungs[20], 2);
    }

    #[test]
    fn it_does_not_swing() {
        // The next rung is above the budget, though there seems to be room for it.
        let mut controller = Controller::new(COSTS, 3);
        run(&mut controller, 300, 11.0, |cost| cost);
        let rungs = run(&mut controller, 3000, 11.0, |cost| cost);
        let steps = rungs.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(steps <= 8, "{steps}");
        let at_four = rungs.iter().filter(|rung| **rung == 3).count();
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
            assert_eq!(controller.rung(), 3);
        }
    }

    #[test]
    fn a_scene_that_gets_lighter_gets_more() {
        let mut controller = Controller::new(COSTS, 3);
        run(&mut controller, 200, 5.0, |cost| cost);
        assert_eq!(controller.rung(), 2);
        run(&mut controller, 3000, 5.0, |cost| 0.1 * cost);
        assert_eq!(controller.rung(), 5);
    }
}

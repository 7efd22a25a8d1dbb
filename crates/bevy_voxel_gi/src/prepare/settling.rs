//! The settling clock: counts the frames in which light is computed, and says when it has settled.
//!
//! Time is counted in rounds, in each of which every voxel is updated once. While things change, and for the
//! [`REST`] rounds after, light is averaged over a few rounds, so that it follows; over more where nothing but the volume
//! moves. Then the same begins whatever has been before, so that the same scene always settles to the same light: rays
//! begin with their first set, and once the bounces of what has been before have faded, a new mean of [`SETTLED_MEAN`]
//! rounds. Nothing of that shows: a change keeps the mean, and pixels keep the former one until the new has as many rounds.

/// Rounds in the mean that pixels read while things change; later ones weigh more.
const HISTORY: u32 = 8;

/// Rounds for which the mean of a scene at rest counts once something changes. The more, the later change arrives;
/// with none, the noise of a single round shows everywhere.
const KEPT: u32 = 1;

/// Rounds after a change in which light that differs much from its mean counts as changed, and not as noise. Later
/// than that it would bias the mean, as rare bright rays are missing from most rounds.
const CHANGING: u32 = REST + BOUNCES;

/// Rounds without a change after which a scene is at rest: rays begin with their first set.
const REST: u32 = 8;

/// The same after the volume has moved. A new mean that is interrupted early shows its noise, so it begins only where a
/// camera stands still, and not between the steps of a slow one.
const REST_AFTER_MOVE: u32 = 60;

/// Rounds from then until the new mean begins, in which the light that bounces becomes that of the new rays.
const BOUNCES: u32 = 8;

/// Rounds in the settled mean: four rotations of all ray sets.
const SETTLED_MEAN: u32 = 32;

/// Greatest number of rounds in the mean, where light is computed on after it has settled and where only the volume moves.
const LONGEST_MEAN: u32 = 64;

/// Rounds after the start in which bounces propagate before averaging starts.
const WARM_UP: u32 = 4;

/// Rounds after the last change in which traced light settles.
pub(crate) const SETTLE: u32 = REST + BOUNCES + SETTLED_MEAN;

/// How fast the light of a volume settles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pace {
    /// Number of frames in a round.
    pub interval: u32,
    /// Number of rounds after the last change in which the light settles.
    pub rounds: u32,
}

/// See the module documentation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct SettlingClock {
    /// The number of the frame, which determines the directions of rays.
    frame: u32,
    /// Frames since the scene changed or the volume moved.
    since_change: u32,
    /// Frames since the scene changed.
    since_scene_change: u32,
    /// Rounds without a change after which the scene is at rest, where they are more than [`REST`].
    longer_rest: u32,
    /// Frames in the mean, those of the warm-up included.
    mean: u32,
}

impl SettlingClock {
    /// Something that the light depends on has changed. `has_moved` tells whether the volume has moved, too: its light
    /// remains then.
    pub(crate) fn change(&mut self, pace: Pace, has_moved: bool) {
        if self.since_change >= REST * pace.interval && !has_moved {
            self.mean = self.mean.min((WARM_UP + KEPT) * pace.interval);
        }
        self.since_change = 0;
        self.since_scene_change = 0;
        self.longer_rest = 0;
    }

    /// Nothing but the volume has moved, so that this part of its voxels is new: they have had no rounds, and those that
    /// came just before few.
    pub(crate) fn move_volume(&mut self, pace: Pace, part: f32) {
        let kept = (1.0 - 2.0 * part).max(0.0);
        let warm_up = WARM_UP * pace.interval;
        let after_warm_up = self
            .mean
            .saturating_sub(warm_up)
            .min(LONGEST_MEAN * pace.interval);
        self.mean = self.mean.min(warm_up) + (kept * after_warm_up as f32) as u32;
        // Where all voxels are new, light bounces first.
        if kept == 0.0 {
            self.mean = 0;
        }
        self.since_change = 0;
        self.longer_rest = REST_AFTER_MOVE - REST;
    }

    /// Frames since something changed, without those by which a rest begins later.
    fn at_rest(&self, pace: Pace) -> u32 {
        let later = self.longer_rest * pace.interval;
        self.since_change.saturating_sub(later)
    }

    pub(crate) fn has_settled(&self, pace: Pace) -> bool {
        self.at_rest(pace) >= pace.rounds * pace.interval
    }

    pub(crate) fn frame(&self) -> u32 {
        self.frame
    }

    /// Rounds since the new mean began.
    fn rounds_of_new_mean(&self, pace: Pace) -> Option<u32> {
        (self.at_rest(pace) / pace.interval).checked_sub(REST + BOUNCES)
    }

    /// Blend factor of this frame in the mean that pixels read.
    pub(crate) fn blend(&self, pace: Pace) -> f32 {
        let rounds = (self.mean / pace.interval + 1).saturating_sub(WARM_UP);
        let most = match self.rounds_of_new_mean(pace) {
            None if self.is_changing(pace) => HISTORY,
            _ => LONGEST_MEAN,
        };
        1.0 / rounds.clamp(1, most) as f32
    }

    /// Whether something in the scene has changed lately.
    pub(crate) fn is_changing(&self, pace: Pace) -> bool {
        self.since_scene_change < CHANGING * pace.interval
    }

    /// Whether pixels keep the light that they have, as the new mean has too few rounds yet.
    pub(crate) fn is_held(&self, pace: Pace) -> bool {
        self.rounds_of_new_mean(pace)
            .is_some_and(|rounds| rounds + 1 < HISTORY)
    }

    /// The light of this frame is computed.
    pub(crate) fn advance(&mut self, pace: Pace) {
        self.frame = self.frame.wrapping_add(1);
        self.since_change = self.since_change.saturating_add(1);
        self.since_scene_change = self.since_scene_change.saturating_add(1);
        self.mean = self.mean.saturating_add(1);
        let at_rest = self.at_rest(pace);
        if at_rest == REST * pace.interval {
            self.frame = 0;
        }
        if at_rest == (REST + BOUNCES) * pace.interval {
            self.mean = WARM_UP * pace.interval;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace {
        interval: 1,
        rounds: SETTLE,
    };

    /// Computes frames until the light has settled, and returns their number.
    fn settle(clock: &mut SettlingClock, pace: Pace) -> u32 {
        let mut frames = 0;
        while !clock.has_settled(pace) {
            clock.advance(pace);
            frames += 1;
        }
        frames
    }

    /// The numbers of rounds in the mean, in the next frames.
    fn means(clock: &mut SettlingClock, frames: u32) -> Vec<u32> {
        let mut mean = || {
            let blend = clock.blend(PACE);
            clock.advance(PACE);
            blend.recip().round() as u32
        };
        (0..frames).map(|_| mean()).collect()
    }

    #[test]
    fn light_settles_after_whole_sequences_of_rays() {
        for interval in [1, 2, 3, 16] {
            let pace = Pace { interval, ..PACE };
            let mut clock = SettlingClock::default();
            clock.change(pace, false);
            assert_eq!(settle(&mut clock, pace), SETTLE * interval);
            assert_eq!(clock.frame(), (SETTLE - REST) * interval);
        }
        let propagated = Pace { rounds: 16, ..PACE };
        assert_eq!(settle(&mut SettlingClock::default(), propagated), 16);
    }

    #[test]
    fn light_settles_in_the_same_way_whatever_has_been_before() {
        let mut fresh = SettlingClock::default();
        fresh.change(PACE, false);
        let mut changed = fresh.clone();
        settle(&mut changed, PACE);
        for frame in 0..100 {
            changed.change(PACE, frame % 2 == 0);
            changed.advance(PACE);
        }
        changed.change(PACE, false);
        let state = |clock: &mut SettlingClock| {
            let state = (clock.frame(), clock.blend(PACE), clock.is_held(PACE));
            clock.advance(PACE);
            state
        };
        for frame in 0..2 * SETTLE {
            let states = (state(&mut fresh), state(&mut changed));
            assert!(states.0 == states.1 || frame < REST + BOUNCES, "{frame}");
        }
    }

    #[test]
    fn the_mean_starts_after_the_first_bounces_and_anew_after_a_rest() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        let growing = [1, 1, 1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 8, 8, 8, 8];
        assert_eq!(means(&mut clock, 16), growing);
        let settled: Vec<_> = (1..=64).chain([64]).collect();
        assert_eq!(means(&mut clock, 65), settled);
    }

    #[test]
    fn a_change_after_a_rest_keeps_some_of_the_mean() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        settle(&mut clock, PACE);
        let mut moved = clock.clone();
        clock.change(PACE, false);
        assert_eq!(means(&mut clock, 9), [2, 3, 4, 5, 6, 7, 8, 8, 8]);
        moved.change(PACE, true);
        assert_eq!(means(&mut moved, 2), [8, 8]);
    }

    #[test]
    fn a_move_of_the_volume_is_no_change_of_the_scene() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        settle(&mut clock, PACE);
        let frame = clock.frame();
        for step in 0..100 {
            clock.move_volume(PACE, 0.125);
            assert!(!clock.is_changing(PACE) && !clock.is_held(PACE));
            means(&mut clock, 30);
            assert_eq!(clock.frame(), frame + 30 * (step + 1));
        }
        assert_eq!(means(&mut clock.clone(), 1), [64]);
        clock.move_volume(PACE, 0.125);
        assert_eq!(means(&mut clock.clone(), 1), [48 + 1]);
        let frames = settle(&mut clock, PACE);
        assert_eq!(frames, SETTLE + REST_AFTER_MOVE - REST);
        // It has the rays of a scene that has not moved.
        assert_eq!(clock.frame(), SETTLE - REST);
        // In a fast flight the mean is as short as the time that a voxel is in the level.
        for _ in 0..100 {
            clock.move_volume(PACE, 0.0625);
            means(&mut clock, 1);
        }
        assert!((4..=9).contains(&means(&mut clock.clone(), 1)[0]));
        clock.move_volume(PACE, 1.0);
        assert_eq!(means(&mut clock, 7), [1, 1, 1, 1, 1, 2, 3]);
    }

    #[test]
    fn continuous_changes_leave_the_mean_and_the_rays() {
        let mut clock = SettlingClock::default();
        for frame in 0..100 {
            clock.change(PACE, false);
            assert_eq!(clock.frame(), frame);
            clock.advance(PACE);
        }
        assert_eq!(clock.blend(PACE), 1.0 / 8.0);
    }

    #[test]
    fn pixels_keep_the_former_mean_while_the_new_one_is_short() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        let mut held = (0..SETTLE).filter(|_| {
            let is_held = clock.is_held(PACE);
            clock.advance(PACE);
            is_held
        });
        assert!(
            held.by_ref()
                .eq(REST + BOUNCES..REST + BOUNCES + HISTORY - 1)
        );
    }
}

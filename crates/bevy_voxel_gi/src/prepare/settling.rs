//! The settling clock: counts the frames in which light is computed, and says when it has settled.
//!
//! Light settles after a restart, which begins with the first ray set and a new mean, and after a change,
//! which continues with both. Time is counted in rounds, in each of which every voxel is updated once.

/// Rounds over which the light that pixels read is averaged, as an exponential mean, while things change.
const HISTORY: u32 = 8;

/// Rounds after a change from which on the mean grows: by then, what was before the change has a share of
/// (7/8)³² = 1.4%, which falls further as the mean grows, and the bounces have settled.
const STEADY: u32 = 32;

/// Greatest number of rounds in the mean.
const STEADY_HISTORY: u32 = 64;

/// Rounds after a change in which light that differs much from its mean counts as changed, and not as
/// noise. Later than that it would bias the mean, as rare bright rays are missing from most rounds.
const CHANGING: u32 = 16;

/// Light settles after a multiple of this number of rounds: all ray sets have been traced, and changes that
/// took a few frames to arrive settle to the same light as those that arrived at once.
const SETTLE_STEP: u32 = 16;

/// Rounds after a restart in which bounces propagate before averaging starts.
const WARM_UP: u32 = 4;

/// How fast the light of a volume settles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pace {
    /// Number of frames in a round.
    pub interval: u32,
    /// Number of rounds that the light needs to settle.
    pub rounds: u32,
}

/// See the module documentation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct SettlingClock {
    /// Frames since a restart by a change after a pause. It determines the directions of rays, so the same
    /// change always settles to the same light.
    frame: u32,
    /// Frames since the light was last restarted.
    since_restart: u32,
    /// Frames since something changed.
    since_change: u32,
    /// Frames still to compute until the light has settled.
    unsettled: u32,
}

impl SettlingClock {
    /// Something that the light depends on has changed. After a pause the light is restarted, unless the
    /// volume has moved: then it keeps its light.
    pub(crate) fn change(&mut self, pace: Pace, has_moved: bool) {
        if self.since_change > HISTORY * pace.interval && !has_moved {
            self.since_restart = 0;
            self.frame = 0;
        }
        self.since_change = 0;
        self.unsettled = pace.rounds * pace.interval;
    }

    /// Whether the light has settled.
    pub(crate) fn has_settled(&self, pace: Pace) -> bool {
        self.unsettled == 0 && self.frame.is_multiple_of(SETTLE_STEP * pace.interval)
    }

    /// The number of this frame.
    pub(crate) fn frame(&self) -> u32 {
        self.frame
    }

    /// Blend factor of this frame in the mean that pixels read.
    pub(crate) fn blend(&self, pace: Pace) -> f32 {
        let since_restart = (self.since_restart / pace.interval + 1).saturating_sub(WARM_UP);
        let steady = (self.since_change / pace.interval).saturating_sub(STEADY);
        1.0 / since_restart.clamp(1, (HISTORY + steady).min(STEADY_HISTORY)) as f32
    }

    /// Whether something has changed lately.
    pub(crate) fn is_changing(&self, pace: Pace) -> bool {
        self.since_change < CHANGING * pace.interval
    }

    /// The light of this frame is computed.
    pub(crate) fn advance(&mut self) {
        self.frame = self.frame.wrapping_add(1);
        self.since_restart = self.since_restart.saturating_add(1);
        self.since_change = self.since_change.saturating_add(1);
        self.unsettled = self.unsettled.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace {
        interval: 1,
        rounds: 40,
    };

    /// Computes frames until the light has settled, and returns their number.
    fn settle(clock: &mut SettlingClock, pace: Pace) -> u32 {
        let mut frames = 0;
        while !clock.has_settled(pace) {
            clock.advance();
            frames += 1;
        }
        frames
    }

    #[test]
    fn light_settles_after_whole_sequences_of_rays() {
        for interval in [1, 2, 3, 16] {
            let pace = Pace { interval, ..PACE };
            let mut clock = SettlingClock::default();
            clock.change(pace, false);
            assert_eq!(settle(&mut clock, pace), 48 * interval);
        }
    }

    #[test]
    fn a_change_after_a_pause_restarts_the_light() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        let fresh = clock.clone();
        settle(&mut clock, PACE);
        clock.change(PACE, false);
        assert_eq!(clock, fresh);
    }

    #[test]
    fn a_volume_that_moves_keeps_its_mean() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        settle(&mut clock, PACE);
        clock.change(PACE, true);
        assert_eq!((clock.frame(), clock.blend(PACE)), (48, 1.0 / 8.0));
        assert!(clock.is_changing(PACE) && !clock.has_settled(PACE));
    }

    #[test]
    fn continuous_changes_do_not_restart_the_light() {
        let mut clock = SettlingClock::default();
        for frame in 0..100 {
            clock.change(PACE, false);
            assert_eq!(clock.frame(), frame);
            clock.advance();
        }
        assert_eq!(clock.blend(PACE), 1.0 / 8.0);
        // 40 rounds from the last change on, then up to a multiple of 16.
        assert_eq!(100 + settle(&mut clock, PACE), 144);
    }

    #[test]
    fn the_mean_grows_long_after_a_change() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        let mut blends = (0..100).map(|_| {
            let blend = clock.blend(PACE);
            clock.advance();
            blend.recip().round() as u32
        });
        assert_eq!(blends.nth(32), Some(8));
        assert_eq!(blends.next(), Some(9));
        assert_eq!(blends.last(), Some(STEADY_HISTORY));
    }

    #[test]
    fn the_mean_starts_after_the_bounces() {
        let mut clock = SettlingClock::default();
        clock.change(PACE, false);
        let blends: Vec<_> = (0..16)
            .map(|_| {
                let blend = clock.blend(PACE);
                clock.advance();
                blend.recip().round() as u32
            })
            .collect();
        assert_eq!(blends, [1, 1, 1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 8, 8, 8, 8]);
    }
}

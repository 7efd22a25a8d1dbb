//! The light from outside of a volume.

use bevy::prelude::*;

use super::range::clamped_or;

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

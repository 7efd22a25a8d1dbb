//! A time budget.

use bevy::prelude::*;

#[cfg(doc)]
use super::shared::VoxelGiSettings;

/// Limits the GPU time that the light of all volumes takes per frame, while this resource is there.
///
/// While the app runs, the most accurate setting that fits is chosen from GPU timestamps: the number of
/// rays of [`Trace`](crate::Solver::Trace) and of ambient occlusion, or of iterations of
/// [`Propagate`](crate::Solver::Propagate), and where the fewest are too many, the fraction of the volume
/// that is updated per frame. The values of these in [`VoxelGiSettings`] are ignored; resolution, solver and
/// bounces are not changed.
///
/// Needs [`VoxelGiBudgetPlugin`](crate::VoxelGiBudgetPlugin) and an adapter with timestamp queries (`TIMESTAMP_QUERY`: Vulkan and
/// DirectX 12). Without them, a warning is logged and the settings are used as they are. A budget below
/// the time of the cheapest setting is exceeded.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct VoxelGiBudget {
    /// GPU time in milliseconds per frame, above 0. Default 2.
    pub milliseconds: f32,
}

impl Default for VoxelGiBudget {
    fn default() -> Self {
        Self { milliseconds: 2.0 }
    }
}

impl VoxelGiBudget {
    /// Returns a copy with the budget clamped to its range.
    pub fn clamped(self) -> Self {
        Self {
            milliseconds: self.milliseconds.max(0.0),
        }
    }
}

//! State and memory of the volume.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::prelude::*;

/// The state of the volumes and their cost; updated each frame.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct VoxelGiReport {
    /// Whether the light is being computed.
    pub state: VoxelGiState,
    /// GPU memory in bytes, as allocated.
    pub memory: u64,
    /// Number of triangles in the volume.
    pub triangles: u64,
    /// Number of triangles that were voxelised when something last changed, in all levels: those near what has changed.
    /// It counts whole batches of 64, and is some frames late.
    pub voxelized_triangles: u64,
    /// Whether the patch of Bevy's shader applies; else the volume is read as a plain irradiance volume.
    pub receiver_patched: bool,
}

/// Whether the light of the volume is being computed.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum VoxelGiState {
    /// There is no volume, or its pipelines are not ready.
    #[default]
    Absent,
    /// The light is computed each frame.
    Running,
    /// Nothing has changed for as long as the light needs to settle, so nothing is computed.
    Settled,
}

/// Transfers the report from the render world to the main world.
#[derive(Resource, Clone, Default)]
pub(crate) struct SharedReport(Arc<Mutex<VoxelGiReport>>);

impl SharedReport {
    pub(crate) fn set(&self, report: VoxelGiReport) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = report;
    }
}

pub(crate) fn receive_report(shared: Res<SharedReport>, mut report: ResMut<VoxelGiReport>) {
    let newest = *shared.0.lock().unwrap_or_else(PoisonError::into_inner);
    report.set_if_neq(newest);
}

//! What became of the volume.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::prelude::*;

/// What the volume does, and what it costs; renewed each frame.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VoxelGiReport {
    /// What it does.
    pub state: VoxelGiState,
    /// Bytes on the GPU, as allocated.
    pub memory: u64,
    /// Triangles in the volume.
    pub triangles: u64,
    /// Bevy's shader reads the volume by our code, rather than as a plain irradiance volume.
    pub receiver_patched: bool,
}

/// What the volume does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VoxelGiState {
    /// There is none, or its pipelines are not ready.
    #[default]
    Absent,
    /// It is computed.
    Running,
    /// Nothing has changed for as long as the light needed to settle: nothing is computed.
    Settled,
}

/// The way of the report from the renderer to the app.
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

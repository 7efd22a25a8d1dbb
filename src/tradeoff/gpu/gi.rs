//! The passes of global illumination in a volume that is renewed in each frame, and what pixels pay to read it.

use bevy::utils::default;
use bevy_voxel_gi::{Bounces, Receiver, Solver, VoxelGiSettings, VoxelLight};

use crate::{
    record::{Measurement, ReportAdapter},
    tradeoff::{
        interleaved::{Candidate, benchmark_apps},
        plan::Plan,
        study::TradeoffError,
        voxel_gi::load,
    },
};

/// The setting of the row without a volume.
pub const WITHOUT: &str = "no volume";
/// About as many triangles as a furnished room has.
const TRIANGLES: u32 = 100_000;

/// The rows of a resolution, interleaved.
///
/// # Errors
/// [`TradeoffError`] where a frame cannot be rendered.
pub fn rows(
    resolution: u32,
    size: [u32; 2],
    plan: &Plan,
) -> Result<(ReportAdapter, Vec<Measurement>), TradeoffError> {
    let mut candidates: Vec<Candidate<_>> = Vec::new();
    let mut adapter = ReportAdapter::default();
    for (name, light) in settings(resolution) {
        let (app, row) = load::app(TRIANGLES, light, size)?;
        adapter = app.adapter().into();
        let row = Measurement {
            scene: format!("{resolution}^3"),
            setting: name.into(),
            ..row
        };
        candidates.push(load::candidate(app, row));
    }
    Ok((
        adapter,
        benchmark_apps(candidates, plan.rounds, plan.frames)?,
    ))
}

fn settings(resolution: u32) -> [(&'static str, Option<VoxelGiSettings>); 5] {
    let with = |light, receiver| {
        Some(VoxelGiSettings {
            resolution,
            light,
            receiver,
            ..default()
        })
    };
    let bounced = |solver| VoxelLight::GlobalIllumination {
        solver,
        bounces: Bounces::default(),
    };
    let occlusion = VoxelLight::AmbientOcclusion {
        radius: 1.0,
        rays: 16,
    };
    let propagate = bounced(Solver::Propagate { iterations: 96 });
    [
        (WITHOUT, None),
        ("trace", with(default(), default())),
        ("trace per pixel", with(default(), Receiver::PerPixel)),
        ("propagate", with(propagate, default())),
        ("ambient_occlusion", with(occlusion, default())),
    ]
}

//! The study of `bevy_voxel_gi`: how close the light that bounces comes to path tracing, what it
//! costs, and where the time goes.
//!
//! A picture with the volume less one without it is compared with the path-traced indirect light
//! as means of 4 x 4 pixels ([`agreement`]). `bytes` are what the
//! plugin reports. `stage_ms` are its passes on the GPU, each frame renewed in full; `gpu_ms` is
//! the whole frame, pixels included.
//!
//! | module | gives |
//! | --- | --- |
//! | [`mod@settings`] | what is measured, by name |
//! | [`mod@render`] | a setting in a scene |
//! | [`mod@noise`] | noise on flat walls, settled and while a light moves |
//! | [`arcade`] | a scene of curved meshes with textures, whose light moves and whose door opens |
//! | [`arcade_table`] | its rows in Markdown |
//! | [`load`] | the same setting with more and more triangles |
//! | [`mod@summary`] | what a user chooses between |

pub mod arcade;
pub mod arcade_table;
pub mod load;
pub mod noise;
mod picture;
pub mod render;
pub mod settings;
pub mod summary;

use indicatif::ProgressBar;

use super::{
    interleaved::benchmark_apps,
    plan::Plan,
    study::{Study, TradeoffError},
};
use crate::record::Report;
use bevy_frugal_lab::boxes::TracedScene;
#[cfg(doc)]
use bevy_frugal_lab::boxes::agreement;

/// The study.
pub const STUDY: Study = Study {
    name: "voxel_gi",
    measure,
    summary: summary::summary,
    tables: arcade_table::tables,
};

fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
    let mut report = Report::default();
    if plan.frame.is_none() {
        return Ok(report);
    }
    let scenes = plan.gi.scenes.iter().map(|name| TracedScene::read(name));
    let scenes: Vec<_> = scenes.collect::<Result<_, _>>()?;
    let settings = settings::wanted(&plan.gi)?;
    progress.set_length((scenes.len() * settings.len() + plan.gi.triangles.len()) as u64);
    for scene in &scenes {
        let mut candidates = Vec::new();
        for setting in &settings {
            progress.set_message(format!("{}: {}", scene.scene.name, setting.name));
            let (candidate, adapter) = render::candidate(scene, setting)?;
            candidates.push(candidate);
            report.adapter = adapter;
            progress.inc(1);
        }
        let rows = benchmark_apps(candidates, plan.gi.rounds, plan.gi.frames)?;
        report.measurements.extend(rows);
    }
    if let Some(plan) = &plan.gi.arcade {
        let (rows, adapter) = arcade::rows(plan, &settings, progress)?;
        report.measurements.extend(rows);
        report.adapter = adapter;
    }
    report.measurements.extend(load::rows(&plan.gi, progress)?);
    Ok(report)
}

//! The study of `bevy_voxel_gi`: how close the light that bounces comes to path tracing, what it
//! costs, and where the time goes.
//!
//! A picture with the volume less one without it is compared with the path-traced indirect light
//! as means of 4 x 4 pixels (`agreement`). `bytes` are what the
//! plugin reports. `stage_ms` are its passes on the GPU, each frame renewed in full; `gpu_ms` is
//! the whole frame, pixels included.

use bevy_frugal_lab::boxes::TracedScene;
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use self::settings::SPANS;
use crate::{
    benchmark::benchmark_apps,
    plan::Plan,
    record::{Report, TimeRow, Times},
    run::{Study, TradeoffError},
    summary::{Choice, Need, Quantity, Source, Summary, means},
};

pub mod arcade;
pub mod load;
pub mod meshes;
pub mod motion;
pub mod render;
pub mod settings;
pub mod town;

/// The study.
pub struct VoxelGi;

/// How near a setting comes to path-traced light, and its times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightRow {
    pub scene: String,
    pub setting: String,
    /// Memory on the GPU in bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Mean absolute difference over mean reference, of radiance: 0 and above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_error: Option<f64>,
    /// Mean difference over mean reference, of radiance: above 0 where it is too bright.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<f64>,
    /// The 95th percentile of the relative error of blocks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub percentile_95: Option<f64>,
    /// The share of blocks that are black and should not be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub black: Option<f64>,
    /// Deviation of pixels on flat walls from their smooth neighbourhood over the mean, once all has settled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// The same while a light moves at 1 m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_in_motion: Option<f64>,
    /// Mean absolute difference of pixels between two successive frames of a still scene, over their mean. In a flight, the
    /// root mean square of the relative changes of blocks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flicker: Option<f64>,
    /// The greatest relative change of a block from frame to frame in a flight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greatest_change: Option<f64>,
    #[serde(flatten)]
    pub times: Times,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Rows {
    /// Scenes of boxes, whose truth is committed.
    pub boxes: Vec<LightRow>,
    /// The arcade, whose truth is traced.
    pub arcade: Vec<LightRow>,
    /// The town, whose truth is traced.
    pub town: Vec<LightRow>,
    /// More and more triangles.
    pub triangles: Vec<TimeRow>,
}

impl Study for VoxelGi {
    const NAME: &'static str = "voxel_gi";
    type Rows = Rows;

    fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report<Rows>, TradeoffError> {
        let mut report = Report::<Rows>::default();
        if plan.frame.is_none() {
            return Ok(report);
        }
        let plan = &plan.gi;
        let scenes = plan.scenes.iter().map(|name| TracedScene::read(name));
        let scenes: Vec<_> = scenes.collect::<Result<_, _>>()?;
        let settings = settings::selected(plan)?;
        progress.set_length((scenes.len() * settings.len() + plan.triangles.len()) as u64);
        for scene in &scenes {
            let mut candidates = Vec::new();
            for setting in &settings {
                progress.set_message(format!("{}: {}", scene.scene.name, setting.name));
                let candidate = render::candidate(scene, setting)?;
                report.adapter = candidate.0.adapter().into();
                candidates.push(candidate);
                progress.inc(1);
            }
            let rows = benchmark_apps(
                candidates,
                plan.rounds,
                plan.frames,
                Some(SPANS),
                |row, times| LightRow { times, ..row },
            )?;
            report.rows.boxes.extend(rows);
        }
        if let Some(plan) = &plan.arcade {
            (report.rows.arcade, report.adapter) = arcade::rows(plan, &settings, progress)?;
        }
        let volumes = town::selected(&plan.settings);
        if !volumes.is_empty() && !plan.town.cameras.is_empty() {
            (report.rows.town, report.adapter) = town::rows(&plan.town, &volumes, progress)?;
        }
        report.rows.triangles = load::rows(plan, progress)?;
        Ok(report)
    }

    fn summary(rows: &Rows) -> Summary {
        summary(&rows.boxes)
    }

    fn tables(rows: &Rows) -> String {
        arcade::tables(&rows.arcade) + &town::tables(&rows.town)
    }
}

/// Mean relative error over all scenes of boxes with path-traced light, and the time of the plugin's passes.
fn summary(rows: &[LightRow]) -> Summary {
    let rows = || rows.iter().filter(|row| row.relative_error.is_some());
    let errors = means(rows().map(|row| (&row.setting, row.relative_error)));
    let times = means(rows().map(|row| {
        let stages: f64 = row.times.stage_ms.values().sum();
        let time = (stages > 0.0).then_some(stages).or(row.times.gpu_ms);
        (&row.setting, time)
    }));
    let choices = errors.iter().filter_map(|(name, error)| {
        Some(Choice {
            name: name.to_string(),
            error: 100.0 * error,
            cost: *times.get(name)?,
            source: Source::Ours,
        })
    });
    Summary {
        title: "bevy_voxel_gi: error of the bounced light against time".into(),
        error: Quantity::less("relative error", "%", 1).logarithmic_from(0.1),
        cost: Quantity::less("time of the volume, renewed in full", "ms", 1).logarithmic_from(1e-3),
        choices: choices.collect(),
        needs: vec![
            Need::LeastError,
            Need::Error(10.0),
            Need::Error(20.0),
            Need::LeastCost,
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_for_each_setting_with_error_and_time() {
        let row = |scene: &str, setting: &str, relative_error, stage| LightRow {
            scene: scene.into(),
            setting: setting.into(),
            relative_error,
            times: Times {
                stage_ms: [("gather".to_string(), stage), ("inject".into(), 1.0)].into(),
                ..Times::default()
            },
            ..LightRow::default()
        };
        let found = summary(&[
            row("a", "trace", Some(0.1), 3.0),
            row("b", "trace", Some(0.3), 5.0),
            row("a", "ambient_occlusion", None, 1.0),
        ]);
        let found = found.choices;
        assert_eq!(found.len(), 1);
        assert!((found[0].error - 20.0).abs() < 1e-9 && (found[0].cost - 5.0).abs() < 1e-9);
    }
}

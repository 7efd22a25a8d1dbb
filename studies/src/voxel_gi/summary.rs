//! The settings as error against the time of the volume.

use super::render::REFERENCE;
use crate::{
    record::{Measurement, Report},
    summary::{Choice, Need, Quantity, Source, Summary, means},
};

/// Mean relative error over all scenes of boxes with path-traced light, and the time of the plugin's passes.
pub fn summary(report: &Report) -> Summary {
    let compared = |row: &&Measurement| row.reference == REFERENCE && row.relative_error.is_some();
    let rows = || report.measurements.iter().filter(compared);
    let errors = means(rows(), |row| row.relative_error);
    let times = means(rows(), |row| {
        let stages: f64 = row.stage_ms.values().sum();
        (stages > 0.0).then_some(stages).or(row.gpu_ms)
    });
    let choices = errors.iter().filter_map(|(name, error)| {
        Some(Choice {
            name: name.clone(),
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
        let row = |scene: &str, setting: &str, relative_error, stage| Measurement {
            scene: scene.into(),
            setting: setting.into(),
            reference: REFERENCE.into(),
            relative_error,
            stage_ms: [("gather".to_string(), stage), ("inject".into(), 1.0)].into(),
            ..Measurement::default()
        };
        let report = Report {
            measurements: vec![
                row("a", "trace", Some(0.1), 3.0),
                row("b", "trace", Some(0.3), 5.0),
                row("a", "ambient_occlusion", None, 1.0),
            ],
            ..Report::default()
        };
        let found = summary(&report).choices;
        assert_eq!(found.len(), 1);
        assert!((found[0].error - 20.0).abs() < 1e-9 && (found[0].cost - 5.0).abs() < 1e-9);
    }
}

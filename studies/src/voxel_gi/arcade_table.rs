//! The rows of the arcade in Markdown.

use std::fmt::Write;

use super::arcade::{FRAMES, REFERENCE};
use crate::record::{Measurement, Report};
use bevy_frugal_lab::meshes::arcade::ArcadeState;

/// A table of the settings in each state, and one of the frames after a change; empty where nothing was measured.
pub fn tables(report: &Report) -> String {
    let rows = || {
        report
            .measurements
            .iter()
            .filter(|row| row.reference == REFERENCE)
    };
    let usual = ArcadeState::Usual.name();
    let settings: Vec<_> = rows().filter(|row| row.scene == usual).collect();
    if settings.is_empty() {
        return String::new();
    }
    let cell = |scene: &str, setting: &str| {
        let row = rows().find(|row| row.scene == scene && row.setting == setting);
        row.map_or(String::new(), error_and_bias)
    };
    let names = ArcadeState::ALL.map(ArcadeState::name);
    let mut text = format!(
        "\n| setting | {} |\n| --- | --- | --- | --- |\n",
        names.join(" | ")
    );
    for row in &settings {
        let cells = names.map(|scene| cell(scene, &row.setting));
        let _ = writeln!(text, "| {} | {} |", row.setting, cells.join(" | "));
    }
    let headings = FRAMES.map(|frame| format!("frame {frame}")).join(" | ");
    let _ = write!(
        text,
        "\n| after the change | {headings} | settled |\n| --- | --- | --- | --- | --- |\n"
    );
    for row in &settings {
        for scene in &names[1..] {
            let frames =
                FRAMES.map(|frame| cell(scene, &format!("{}, frame {frame}", row.setting)));
            let settled = cell(scene, &row.setting);
            let _ = writeln!(
                text,
                "| {scene}, {} | {} | {settled} |",
                row.setting,
                frames.join(" | ")
            );
        }
    }
    text
}

fn error_and_bias(row: &Measurement) -> String {
    let percent = |value: Option<f64>| 100.0 * value.unwrap_or(f64::NAN);
    format!(
        "{:.1}% / {:+.1}%",
        percent(row.relative_error),
        percent(row.bias)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_a_line_of_states_and_changes_one_of_frames() {
        let row = |scene: ArcadeState, setting: &str, error| Measurement {
            scene: scene.name().into(),
            setting: setting.into(),
            reference: REFERENCE.into(),
            relative_error: Some(error),
            bias: Some(-error),
            ..Measurement::default()
        };
        let mut report = Report::default();
        assert_eq!(tables(&report), "");
        for (i, state) in ArcadeState::ALL.into_iter().enumerate() {
            report
                .measurements
                .push(row(state, "trace", 0.1 * i as f64));
        }
        let changed = row(ArcadeState::DoorOpen, "trace, frame 8", 0.5);
        report.measurements.push(changed);
        let text = tables(&report);
        for line in [
            "| trace | 0.0% / -0.0% | 10.0% / -10.0% | 20.0% / -20.0% |",
            "| arcade, door open, trace |  | 50.0% / -50.0% |  | 20.0% / -20.0% |",
        ] {
            assert!(text.lines().any(|found| found == line), "{text}");
        }
    }
}

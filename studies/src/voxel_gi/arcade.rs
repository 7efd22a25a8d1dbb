//! The arcade: a scene of curved meshes with textures, whose light moves and whose door opens.

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::HeadlessError,
    meshes::arcade::{Arcade, ArcadeSettings, ArcadeState},
};
use bevy_voxel_gi::VoxelGiVolume;
use indicatif::ProgressBar;

use crate::{
    page::table,
    plan::ArcadePlan,
    record::ReportAdapter,
    voxel_gi::{
        LightRow,
        meshes::{MeshApp, View, cell, changes_table, error_and_bias, traced},
        settings::Setting,
    },
};

/// The settings of the study that the arcade is measured with.
const SETTINGS: [&str; 5] = [
    "trace",
    "trace per pixel",
    "propagate",
    "trace 16^3",
    "trace 64^3",
];

/// The rows of those settings that are measured in the arcade, and the adapter.
pub fn rows(
    plan: &ArcadePlan,
    settings: &[Setting],
    progress: &ProgressBar,
) -> Result<(Vec<LightRow>, ReportAdapter), HeadlessError> {
    progress.set_message("arcade: path tracing");
    let views = views(plan.scene);
    let truth = traced(&views, plan.samples);
    let mut app = MeshApp::new(views, &truth)?;
    let mut rows = Vec::new();
    for setting in settings {
        if SETTINGS.contains(&setting.name.as_str()) {
            progress.set_message(format!("arcade: {}", setting.name));
            rows.extend(setting_rows(&mut app, setting)?);
        }
    }
    Ok((rows, app.app.adapter().into()))
}

/// The arcade in all of its states.
pub fn views(settings: ArcadeSettings) -> Vec<View> {
    let arcade = Arcade::new(settings);
    let [usual, changes @ ..] = ArcadeState::ALL.map(|state| (state.name(), arcade.scene(state)));
    let changes = changes.into();
    vec![View { usual, changes }]
}

/// The rows of a volume that fits the arcade.
pub fn setting_rows(app: &mut MeshApp, setting: &Setting) -> Result<Vec<LightRow>, HeadlessError> {
    let settings = &setting.settings;
    app.rows(&setting.name, settings, |scene| {
        let (center, size) = scene.volume(settings.resolution);
        let volume = VoxelGiVolume::fixed(size);
        (volume, Transform::from_translation(center))
    })
}

/// A table of the settings in each state, and one of the frames after a change; empty where nothing was measured.
pub fn tables(rows: &[LightRow]) -> String {
    let names = ArcadeState::ALL.map(ArcadeState::name);
    let settings = rows.iter().filter(|row| row.scene == names[0]);
    let settings: Vec<_> = settings.map(|row| row.setting.as_str()).collect();
    if settings.is_empty() {
        return String::new();
    }
    let usual = settings.iter().map(|setting| {
        let cells = names.map(|scene| cell(rows, scene, setting, error_and_bias));
        [vec![setting.to_string()], cells.into()].concat()
    });
    let heads = [&["setting"], &names[..]].concat();
    let usual = table(&heads, usual);
    let changes = changes_table(rows, &settings, &names[1..]);
    format!("\n{usual}\n{changes}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_a_line_of_states_and_changes_one_of_frames() {
        let row = |scene: ArcadeState, setting: &str, error| LightRow {
            scene: scene.name().into(),
            setting: setting.into(),
            relative_error: Some(error),
            bias: Some(-error),
            ..LightRow::default()
        };
        assert_eq!(tables(&[]), "");
        let mut rows = vec![row(ArcadeState::DoorOpen, "trace, frame 8", 0.5)];
        for (i, state) in ArcadeState::ALL.into_iter().enumerate() {
            rows.push(row(state, "trace", 0.1 * i as f64));
        }
        let text = tables(&rows);
        for line in [
            "| trace | 0.0% / -0.0% | 10.0% / -10.0% | 20.0% / -20.0% |",
            "| arcade, door open, trace |  | 50.0% / -50.0% |  | 20.0% / -20.0% |",
        ] {
            assert!(text.lines().any(|found| found == line), "{text}");
        }
    }
}

//! The town: a level that is larger than the default volume, from several cameras.

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::HeadlessError,
    meshes::{
        MeshScene,
        town::{Town, TownCamera, TownState},
    },
};
use bevy_voxel_gi::{VoxelGiSettings, VoxelGiVolume};
use indicatif::ProgressBar;

use crate::{
    page::table,
    plan::TownPlan,
    record::ReportAdapter,
    voxel_gi::{
        LightRow,
        meshes::{MeshApp, View, cell, changes_table, error_and_bias, percent, traced},
    },
};

/// The volumes that the town is measured with, by their names.
pub const VOLUMES: [&str; 2] = ["one level", FOLLOWING];
/// The one whose cascades follow.
const FOLLOWING: &str = "default";

/// The volume of this name.
fn placed(name: &str, resolution: u32, scene: &MeshScene) -> (VoxelGiVolume, Transform) {
    match name {
        "one level" => {
            let (center, size) = scene.volume(resolution);
            (
                VoxelGiVolume::fixed(size),
                Transform::from_translation(center),
            )
        }
        _ => default(),
    }
}

/// The volumes of these names; all where there are none.
pub fn selected(names: &[String]) -> Vec<&'static str> {
    let is_named = |volume: &&str| names.is_empty() || names.iter().any(|name| name == volume);
    VOLUMES.into_iter().filter(is_named).collect()
}

/// The rows of these volumes, and the adapter.
pub fn rows(
    plan: &TownPlan,
    volumes: &[&str],
    progress: &ProgressBar,
) -> Result<(Vec<LightRow>, ReportAdapter), HeadlessError> {
    progress.set_message("town: path tracing");
    let mut app = app(plan)?;
    let mut rows = Vec::new();
    for volume in volumes {
        progress.set_message(format!("town: {volume}"));
        rows.extend(volume_rows(&mut app, volume, plan.resolution)?);
        if *volume == FOLLOWING {
            progress.set_message("town: flight");
            rows.extend(app.flight_rows(volume, &settings(plan.resolution))?);
        }
    }
    Ok((rows, app.app.adapter().into()))
}

/// The town from the plan's cameras.
pub fn app(plan: &TownPlan) -> Result<MeshApp, HeadlessError> {
    let town = Town::new(plan.picture);
    let views = plan.cameras.iter().map(|camera| {
        let change = camera.change().into_iter();
        View {
            usual: (camera.name(), town.scene(TownState::Usual, *camera)),
            changes: change
                .map(|(state, name)| (name, town.scene(state, *camera)))
                .collect(),
        }
    });
    let views: Vec<_> = views.collect();
    let truth = traced(&views, plan.samples);
    MeshApp::new(views, &truth)
}

/// The rows of a volume of [`VOLUMES`] with so many voxels along an edge.
pub fn volume_rows(
    app: &mut MeshApp,
    name: &str,
    resolution: u32,
) -> Result<Vec<LightRow>, HeadlessError> {
    let settings = settings(resolution);
    app.rows(name, &settings, |scene| placed(name, resolution, scene))
}

fn settings(resolution: u32) -> VoxelGiSettings {
    VoxelGiSettings {
        resolution,
        ..default()
    }
}

/// A table of the volumes from each camera, and one of the frames after a change; empty where nothing was measured.
pub fn tables(rows: &[LightRow]) -> String {
    let volumes = VOLUMES.into_iter();
    let volumes = volumes.filter(|volume| rows.iter().any(|row| row.setting == *volume));
    let volumes: Vec<_> = volumes.collect();
    if volumes.is_empty() {
        return String::new();
    }
    let memory = |volume: &str| {
        let row = rows.iter().find(|row| row.setting == volume);
        let bytes = row.and_then(|row| row.bytes).unwrap_or_default();
        format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
    };
    let lines = TownCamera::ALL.iter().flat_map(|camera| {
        let changed = camera.change().map(|(_, name)| name);
        [Some(camera.name()), changed].into_iter().flatten()
    });
    let is_measured = |scene: &&str| rows.iter().any(|row| row.scene == *scene);
    let lines = lines.filter(is_measured).map(|scene| {
        let cells = volumes.iter().map(|volume| {
            cell(rows, scene, volume, |row| {
                let [blocks, black] = [row.percentile_95, row.black].map(percent);
                format!("{}, {blocks:.0}%, {black:.0}%", error_and_bias(row))
            })
        });
        [scene.to_string()].into_iter().chain(cells).collect()
    });
    let heads: Vec<_> = volumes
        .iter()
        .map(|volume| format!("{volume} ({})", memory(volume)))
        .collect();
    let heads: Vec<_> = ["from"]
        .into_iter()
        .chain(heads.iter().map(String::as_str))
        .collect();
    let usual = table(&heads, lines);
    let changes = TownCamera::ALL.iter().filter_map(|camera| camera.change());
    let changes = changes.map(|(_, name)| name).filter(is_measured);
    let changes: Vec<_> = changes.collect();
    if changes.is_empty() {
        return format!("\n{usual}{}", flight_table(rows));
    }
    let changes = changes_table(rows, &volumes, &changes);
    format!("\n{usual}\n{changes}{}", flight_table(rows))
}

/// A table of the changes from frame to frame in a flight; empty where none was measured.
fn flight_table(rows: &[LightRow]) -> String {
    let flights = rows.iter().filter(|row| row.greatest_change.is_some());
    let lines = flights.map(|row| {
        let changes = [row.flicker, row.greatest_change].map(percent);
        let [mean, most] = changes.map(|change| format!("{change:.2}%"));
        vec![row.scene.clone(), mean, most]
    });
    let lines: Vec<_> = lines.collect();
    if lines.is_empty() {
        return String::new();
    }
    let heads = ["change from frame to frame", "root mean square", "greatest"];
    format!("\n{}", table(&heads, lines))
}

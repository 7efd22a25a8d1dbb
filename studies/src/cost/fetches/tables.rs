//! Tables of the counts, for the plugins' pages.

use std::{collections::BTreeSet, fmt::Write};

use super::record::FetchRow;
use crate::cost::scene::Scene;

/// The table of a plugin's page: fetches of a pixel by setting.
pub fn page(rows: &[FetchRow], plugin: &str) -> String {
    let mut settings = BTreeSet::new();
    let own: Vec<_> = rows.iter().filter(|row| row.plugin == plugin).collect();
    let scenes: Vec<_> = [Scene::BaseColor, Scene::FiveMaps]
        .into_iter()
        .filter(|scene| own.iter().any(|row| row.material == scene.material()))
        .collect();
    let names: Vec<_> = scenes.iter().map(|scene| scene.material()).collect();
    let mut text = format!(
        "| setting | {} |\n| --- |{}\n",
        names.join(" | "),
        " --- |".repeat(names.len())
    );
    let mut line = |name: &str, plugin: &str, setting: &str| {
        let cells: Vec<_> = { names.iter() }
            .map(|material| {
                let is_it = |row: &&FetchRow| {
                    row.plugin == plugin && row.setting == setting && row.material == *material
                };
                rows.iter().find(is_it).map_or(String::new(), cell)
            })
            .collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        }
    };
    if own.iter().any(|row| row.baseline_fetches.is_some()) {
        line("Bevy alone", "bevy", "default");
    }
    if plugin == "voxel_gi" {
        line("Bevy's own irradiance volume", "bevy", "irradiance_volume");
    }
    for row in own.iter().filter(|row| settings.insert(&row.setting)) {
        line(&format!("`{}`", row.setting), plugin, &row.setting);
    }
    text
}

/// All fetches, and over Bevy's; then by kind.
fn cell(row: &FetchRow) -> String {
    let fetches = row.fetches();
    let factor = { row.baseline_fetches.filter(|_| row.plugin != "bevy") }
        .map_or(String::new(), |bevy| format!(" ({:.1})", fetches / bevy));
    let kinds = [row.samples, row.loads, row.gathers, row.comparisons];
    let kinds = kinds.map(|count| format!("{count:.1}"));
    format!("{fetches:.1}{factor}: {}", kinds.join(" + "))
}

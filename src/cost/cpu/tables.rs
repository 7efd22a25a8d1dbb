//! The times as tables.

use std::fmt::Write;

use super::{record::CpuRow, systems::SystemRow};
use crate::cost::configurations::PLUGINS;

/// What a plugin adds to a frame's time on processors, by field of meshes.
pub fn table(rows: &[CpuRow]) -> String {
    let names = PLUGINS.map(|(name, _)| format!("`bevy_{name}`"));
    let mut text = format!(
        "| meshes | materials | moving | replaced | Bevy | {} |\n| --- | --- | --- | --- | --- |{}\n",
        names.join(" | "),
        " --- |".repeat(names.len())
    );
    let field = |row: &CpuRow| (row.meshes, row.materials, row.moving, row.replaced);
    let mut fields: Vec<_> = rows.iter().map(field).collect();
    fields.dedup();
    for of_row @ (meshes, materials, moving, replaced) in fields {
        let same: Vec<_> = rows.iter().filter(|row| field(row) == of_row).collect();
        let cells = PLUGINS.map(|(name, _)| {
            let row = same.iter().find(|row| row.plugin == name);
            row.map_or(String::new(), |row| {
                format!("{:+.1} ± {:.1}", row.process_ms, row.noise_ms)
            })
        });
        let _ = writeln!(
            text,
            "| {meshes} | {materials} | {moving} | {replaced} | {:.1} | {} |",
            same[0].baseline_process_ms,
            cells.join(" | ")
        );
    }
    text
}

/// The plugins' systems by name, with their times where nothing moves, and where some meshes move.
pub fn systems(rows: &[SystemRow]) -> String {
    let meshes = rows.first().map_or(0, |row| row.meshes);
    let mut text = format!(
        "| system, {meshes} meshes | nothing moves, ms | some move, ms |\n| --- | --- | --- |\n"
    );
    let mut names: Vec<_> = rows.iter().map(|row| &row.system).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let cell = |is_moving: bool| {
            let is_it = |row: &&SystemRow| row.system == *name && (row.moving > 0) == is_moving;
            let row = rows.iter().find(is_it);
            row.map_or(String::new(), |row| format!("{:.1}", row.process_ms))
        };
        let _ = writeln!(text, "| `{name}` | {} | {} |", cell(false), cell(true));
    }
    text
}

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

/// The plugins' systems by name, and all of a plugin together, with their times by field of meshes.
pub fn systems(rows: &[SystemRow]) -> String {
    let field = |row: &SystemRow| (row.meshes, row.moving, row.replaced);
    let mut fields: Vec<_> = rows.iter().map(field).collect();
    fields.sort_unstable();
    fields.dedup();
    let heads = fields.iter().map(|(meshes, moving, replaced)| {
        let change = match (moving, replaced) {
            (0, 0) => "nothing changes".to_string(),
            (moving, 0) => format!("{moving} move"),
            (_, replaced) => format!("{replaced} are replaced"),
        };
        format!(" {meshes}: {change} |")
    });
    let mut text = format!(
        "| system, ms |{}\n| --- |{}\n",
        heads.collect::<String>(),
        " --- |".repeat(fields.len())
    );
    let mut names: Vec<_> = rows.iter().map(|row| &row.system).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let cells = fields.iter().map(|of_row| {
            let row = { rows.iter() }.find(|row| row.system == *name && field(row) == *of_row);
            row.map_or(" |".into(), |row| format!(" {:.2} |", row.process_ms))
        });
        let _ = writeln!(text, "| `{name}` |{}", cells.collect::<String>());
    }
    text
}

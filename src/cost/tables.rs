//! Tables of the rows: all of them as text, and those of a plugin for its page.

use std::{collections::BTreeSet, fmt::Write, path::Path};

use super::{CostError, configurations::PLUGINS, record, record::CostRow, scenes::Scene};
use crate::tradeoff::markdown::renewed;

/// The GPU of the pages' tables.
const GPU: &str = "navi31";

/// The columns of a page's first table: material, pass, and what the column is called.
const PLACES: [(Scene, &str, &str); 5] = [
    (Scene::BaseColor, "forward", "base color"),
    (Scene::FiveMaps, "forward", "five maps"),
    (Scene::Masked, "prepass", "alpha mask, prepass"),
    (Scene::Masked, "shadow", "alpha mask, shadow map"),
    (Scene::Deferred, "deferred", "five maps, deferred"),
];
/// The same of a plugin that changes only how materials are lit.
const LIT_PLACES: [(Scene, &str, &str); 3] = [
    PLACES[0],
    PLACES[1],
    (Scene::Deferred, "deferred lighting", "deferred lighting"),
];

/// One line a row, Bevy's figures in brackets.
pub fn text(rows: &[CostRow]) -> String {
    let mut text = String::new();
    for r in rows {
        let bevy = |value: Option<u64>| value.map_or(String::new(), |value| format!("({value})"));
        let _ = writeln!(
            text,
            "{:<7} {:<12} {:<30} {:<22} {:<20} {:>6} {:<7} VALU {:>5} VMEM {:>4} VGPRs {:>3} {:<5} waves {:>2} {:<4} LDS {:>5} scratch {} {:>6} B {:>7.1} ms",
            r.gpu,
            r.plugin,
            r.setting,
            r.material,
            r.pass,
            r.instructions,
            bevy(r.baseline_instructions),
            r.valu,
            r.vmem,
            r.vgprs,
            bevy(r.baseline_vgprs),
            r.waves,
            bevy(r.baseline_waves),
            r.lds,
            r.scratch,
            r.code_bytes,
            r.compile_ms
        );
    }
    text
}

/// The tables of a plugin's page: materials by setting, then the plugin's own passes.
pub fn page(rows: &[CostRow], plugin: &str) -> String {
    let rows: Vec<_> = rows.iter().filter(|row| row.gpu == GPU).collect();
    let own: Vec<_> = rows
        .iter()
        .copied()
        .filter(|row| row.plugin == plugin)
        .collect();
    materials(&rows, &own, plugin) + &passes(&own)
}

fn materials(all: &[&CostRow], own: &[&CostRow], plugin: &str) -> String {
    let places = if plugin == "voxel_gi" {
        &LIT_PLACES[..]
    } else {
        &PLACES[..]
    };
    let bevys = |setting| {
        let is_shown = plugin == "voxel_gi" || setting == "default";
        is_shown.then(|| find_all(all, "bevy", setting))
    };
    let mut lines = vec![(
        "Bevy alone".to_string(),
        bevys("default").unwrap_or_default(),
    )];
    let volume = bevys("irradiance_volume").unwrap_or_default();
    lines.push(("Bevy's own irradiance volume".into(), volume));
    let mut settings = BTreeSet::new();
    for row in own.iter().filter(|row| settings.insert(&row.setting)) {
        lines.push((
            format!("`{}`", row.setting),
            find_all(own, plugin, &row.setting),
        ));
    }
    // A place where nothing of the plugin differs from Bevy needs no column.
    let differs = |row: &&CostRow| {
        row.baseline_instructions
            .is_some_and(|b| b != row.instructions)
    };
    let places: Vec<_> = places
        .iter()
        .filter(|(scene, pass, _)| {
            own.iter()
                .any(|row| is_at(row, *scene, pass) && differs(row))
        })
        .collect();
    let mut text = "| setting |".to_string();
    for (_, _, name) in &places {
        let _ = write!(text, " {name} |");
    }
    let _ = writeln!(text, "\n| --- |{}", " --- |".repeat(places.len()));
    for (name, rows) in lines {
        let cells: Vec<_> = places
            .iter()
            .map(|(scene, pass, _)| cell(&rows, *scene, pass))
            .collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        }
    }
    text
}

fn find_all<'a>(rows: &[&'a CostRow], plugin: &str, setting: &str) -> Vec<&'a CostRow> {
    let is_one = |row: &&CostRow| row.plugin == plugin && row.setting == setting;
    rows.iter().copied().filter(is_one).collect()
}

fn is_at(row: &CostRow, scene: Scene, pass: &str) -> bool {
    row.material == scene.material() && row.pass == pass
}

fn cell(rows: &[&CostRow], scene: Scene, pass: &str) -> String {
    let Some(row) = rows.iter().find(|row| is_at(row, scene, pass)) else {
        return String::new();
    };
    let factor = row
        .baseline_instructions
        .map(|bevy| row.instructions as f64 / bevy as f64);
    let factor = factor.map_or(String::new(), |factor| format!(" ({factor:.2})"));
    format!("{}{factor}, {}, {}", row.instructions, row.vgprs, row.waves)
}

/// The passes that Bevy does not have, each kind of code once, by the first setting that has it.
fn passes(own: &[&CostRow]) -> String {
    let mut seen = BTreeSet::new();
    let is_own = |row: &&&CostRow| {
        row.pass.starts_with("voxel_gi_") || row.pass.starts_with("packed_ycocg_")
    };
    let mut text = String::new();
    for row in own.iter().filter(is_own) {
        if seen.insert((&row.pass, row.instructions, row.vgprs)) {
            let _ = writeln!(
                text,
                "| `{}` | `{}` | {} | {} | {} | {} | {} | {} |",
                row.pass,
                row.setting,
                row.instructions,
                row.valu,
                row.vmem,
                row.vgprs,
                row.waves,
                row.lds
            );
        }
    }
    if text.is_empty() {
        return text;
    }
    let header = "\n| pass | setting | instructions | VALU | VMEM | VGPRs | waves | LDS bytes |\n\
                  | --- | --- | --- | --- | --- | --- | --- | --- |\n";
    header.to_string() + &text
}

/// Renews the tables between `<!-- tradeoff PLUGIN cost -->` and `<!-- end -->` in the plugins' pages.
///
/// # Errors
/// [`CostError::File`] where the figures or a page cannot be read or written.
pub fn renew(folder: &Path) -> Result<(), CostError> {
    let rows = record::read(folder)?;
    for (plugin, _) in PLUGINS {
        let path = format!(
            "{}/crates/bevy_{plugin}/README.md",
            env!("CARGO_MANIFEST_DIR")
        );
        let path = Path::new(&path);
        let document = std::fs::read_to_string(path);
        let document = document.map_err(|source| CostError::File {
            path: path.into(),
            source,
        })?;
        if let Some(text) = renewed(&document, &format!("{plugin} cost"), &page(&rows, plugin)) {
            record::write_text(&text, path)?;
        }
    }
    Ok(())
}

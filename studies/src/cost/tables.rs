//! Tables of the rows, for the plugins' pages.

use bevy_frugal_lab::ROOT;
use std::{collections::BTreeSet, fmt::Write, path::Path};

use super::{
    configurations::PLUGINS,
    cpu,
    error::CostError,
    fetches,
    pipelines::{COPY, TONE_MAPPING},
    record::{self, CostRow},
    scene::Scene,
};
use crate::markdown::renewed;

/// The GPU of the pages' tables and charts.
pub const GPU: &str = "navi31";

/// The columns of a page's first table: material, pass, and what the column is called.
const PLACES: [(Scene, &str, &str); 6] = [
    (Scene::BaseColor, "forward", "base color"),
    (Scene::NormalMapped, "forward", "base color, normals"),
    (Scene::FiveMaps, "forward", "five maps"),
    (Scene::Masked, "prepass", "alpha mask, prepass"),
    (Scene::Masked, "shadow", "alpha mask, shadow map"),
    (Scene::Deferred, "deferred", "five maps, deferred"),
];
/// The same of a plugin that changes only how materials are lit.
const LIT_PLACES: [(Scene, &str, &str); 3] = [
    PLACES[0],
    PLACES[2],
    (Scene::Deferred, "deferred lighting", "deferred lighting"),
];

/// The tables of a plugin's page, of one GPU: materials by setting, then the plugin's own passes.
pub fn page(rows: &[CostRow], gpu: &str, plugin: &str) -> String {
    let rows: Vec<_> = rows.iter().filter(|row| row.gpu == gpu).collect();
    let own: Vec<_> = rows
        .iter()
        .copied()
        .filter(|row| row.plugin == plugin)
        .collect();
    materials(&rows, &own, plugin) + &passes(&rows, &own)
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

/// The passes that Bevy does not have, each kind of code once, by the first setting that has it, and beside those that
/// draw no material Bevy's own such passes.
fn passes(all: &[&CostRow], own: &[&CostRow]) -> String {
    let mut seen = BTreeSet::new();
    let is_resolve = |row: &CostRow| row.pass.starts_with("packed_ycocg_");
    let is_own = |row: &&CostRow| is_resolve(row) || row.pass.starts_with("voxel_gi_");
    let mut rows: Vec<_> = own.iter().copied().filter(is_own).collect();
    if rows.iter().any(|row| is_resolve(row)) {
        let is_bevys =
            |row: &&CostRow| row.is_baseline() && [TONE_MAPPING, COPY].contains(&row.pass.as_str());
        rows.extend(all.iter().copied().filter(is_bevys));
    }
    let mut text = String::new();
    for row in rows {
        if seen.insert((&row.pass, row.instructions, row.vgprs)) {
            let setting = if row.is_baseline() {
                "Bevy alone".into()
            } else {
                let material = match &*row.material {
                    material if material == Scene::BaseColor.material() => String::new(),
                    material => format!(" ({material})"),
                };
                format!("`{}`{material}", row.setting)
            };
            let _ = writeln!(
                text,
                "| `{}` | {setting} | {} | {} | {} | {} | {} | {} |",
                row.pass, row.instructions, row.valu, row.vmem, row.vgprs, row.waves, row.lds
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

/// Renews what stands between `<!-- tradeoff NAME -->` and `<!-- end -->` in the pages: compiled cost and fetches
/// in the plugins', the CPU's time in the repository's.
///
/// # Errors
/// [`CostError::File`] where figures or a page cannot be read, or a page not written.
pub fn renew(rows: &[CostRow], folder: &Path) -> Result<(), CostError> {
    for (page, tables) in pages(rows, folder)? {
        let path = root().join(page);
        let document = std::fs::read_to_string(&path);
        let mut document = document.map_err(|source| CostError::File {
            path: path.clone(),
            source,
        })?;
        for (name, table) in tables {
            if let Some(text) = renewed(&document, &name, &table) {
                document = text;
            }
        }
        record::write_text(&document, &path)?;
    }
    Ok(())
}

fn root() -> &'static Path {
    Path::new(ROOT)
}

/// The path of each page, and its tables by name.
///
/// # Errors
/// [`CostError::File`] where figures cannot be read.
pub fn pages(
    rows: &[CostRow],
    folder: &Path,
) -> Result<Vec<(String, Vec<(String, String)>)>, CostError> {
    let counted = fetches::record::read()?;
    let systems: Vec<cpu::SystemRow> = record::read_json(&folder.join(cpu::FILE))?;
    let mut pages = vec![(
        "README.md".to_string(),
        vec![("cpu systems".to_string(), cpu::table(&systems))],
    )];
    for (plugin, _) in PLUGINS {
        let tables = vec![
            (format!("{plugin} cost"), page(rows, GPU, plugin)),
            (
                format!("{plugin} fetches"),
                fetches::tables::page(&counted, plugin),
            ),
        ];
        pages.push((format!("crates/bevy_{plugin}/README.md"), tables));
    }
    Ok(pages)
}

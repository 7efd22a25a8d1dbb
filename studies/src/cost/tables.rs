//! Tables of the rows, for the plugins' pages.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use bevy_frugal_lab::ROOT;

use crate::{
    cost::{
        CostError,
        configurations::{PLUGINS, Scene},
        cpu, fetches,
        pipelines::{COPY, TONE_MAPPING},
        record::CostRow,
    },
    page::{plugin_page, renew_file, table},
    record::{FileError, read_json, write_text},
    run::{AnyStudy, STUDIES, Study, read},
    summary::{Choice, Quantity, Source, Summary, svg},
    wavelet_tex::{WaveletTex, tunnel::TunnelRow},
};

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
    let places = match plugin {
        "voxel_gi" => &LIT_PLACES[..],
        _ => &PLACES[..],
    };
    // A place where nothing of the plugin differs from Bevy needs no column.
    let differs = |row: &&CostRow| {
        row.baseline_instructions
            .is_some_and(|b| b != row.instructions)
    };
    let is_shown = |(scene, pass, _): &&(Scene, &str, &str)| {
        { own.iter() }.any(|row| is_at(row, *scene, pass) && differs(row))
    };
    let places: Vec<_> = places.iter().filter(is_shown).collect();
    let heads: Vec<_> = { places.iter() }.map(|(_, _, name)| *name).collect();
    let settings = own.iter().map(|row| row.setting.as_str());
    settings_table(&heads, plugin, true, settings, |plugin, setting| {
        let is_one = |row: &&CostRow| row.plugin == plugin && row.setting == setting;
        let rows: Vec<_> = all.iter().copied().filter(is_one).collect();
        let cells = { places.iter() }.map(|(scene, pass, _)| cell(&rows, *scene, pass));
        cells.collect()
    })
}

/// A table with a line for Bevy alone, if it has the same, one for Bevy's own irradiance volume beside global
/// illumination, and one for each setting of a plugin; without those that have nothing. `cells` are those of a plugin's
/// setting.
pub fn settings_table<'a>(
    heads: &[&str],
    plugin: &'a str,
    has_bevys: bool,
    settings: impl Iterator<Item = &'a str>,
    cells: impl Fn(&str, &str) -> Vec<String>,
) -> String {
    let mut lines = Vec::new();
    if has_bevys {
        lines.push(("Bevy alone".to_string(), "bevy", "default"));
    }
    if plugin == "voxel_gi" {
        let name = "Bevy's own irradiance volume".to_string();
        lines.push((name, "bevy", "irradiance_volume"));
    }
    let mut seen = BTreeSet::new();
    let settings = settings.filter(|setting| seen.insert(*setting));
    lines.extend(settings.map(|setting| (format!("`{setting}`"), plugin, setting)));
    let lines = lines.into_iter().filter_map(|(name, plugin, setting)| {
        let cells = cells(plugin, setting);
        let is_any = cells.iter().any(|cell| !cell.is_empty());
        is_any.then(|| [vec![name], cells].concat())
    });
    table(&[&["setting"], heads].concat(), lines)
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
    rows.retain(|row| seen.insert((&row.pass, row.instructions, row.vgprs)));
    if rows.is_empty() {
        return String::new();
    }
    let rows = rows.into_iter().map(|row| {
        let setting = if row.is_baseline() {
            "Bevy alone".into()
        } else {
            let material = match &*row.material {
                material if material == Scene::BaseColor.material() => String::new(),
                material => format!(" ({material})"),
            };
            format!("`{}`{material}", row.setting)
        };
        let figures = [
            row.instructions,
            row.valu,
            row.vmem,
            row.vgprs,
            row.waves,
            row.lds,
        ];
        let figures = figures.map(|figure| figure.to_string());
        [vec![format!("`{}`", row.pass), setting], figures.into()].concat()
    });
    let heads = [
        "pass",
        "setting",
        "instructions",
        "VALU",
        "VMEM",
        "VGPRs",
        "waves",
        "LDS bytes",
    ];
    format!("\n{}", table(&heads, rows))
}

/// Renews what stands between `<!-- tradeoff NAME -->` and `<!-- end -->` in the pages: compiled cost and fetches
/// in the plugins', the CPU's time in the one about measuring.
pub fn renew(rows: &[CostRow], folder: &Path) -> Result<(), CostError> {
    for (page, name, table) in pages(rows, folder)? {
        renew_file(&page, &name, &table)?;
    }
    Ok(())
}

/// The path of each page, and its tables by name.
pub fn pages(rows: &[CostRow], folder: &Path) -> Result<Vec<(PathBuf, String, String)>, CostError> {
    let counted = fetches::read()?;
    let systems: Vec<cpu::SystemRow> = read_json(&folder.join(cpu::FILE))?;
    let measuring = Path::new(ROOT).join("docs/measuring.md");
    let mut pages = vec![(measuring, "cpu systems".into(), cpu::table(&systems))];
    for (plugin, _) in PLUGINS {
        let fetches = fetches::page(&counted, plugin);
        pages.extend([
            (
                plugin_page(plugin),
                format!("{plugin} cost"),
                page(rows, GPU, plugin),
            ),
            (plugin_page(plugin), format!("{plugin} fetches"), fetches),
        ]);
    }
    Ok(pages)
}

/// Where accuracy comes from, relative to the repository.
const ACCURACY: &str = "docs/measurements/llvmpipe";

/// Writes one chart a plugin, named as the plugin.
pub fn draw(rows: &[CostRow], folder: &Path) -> Result<(), FileError> {
    let rows: Vec<_> = rows.iter().filter(|row| row.gpu == GPU).collect();
    for study in &STUDIES {
        let Some(summary) = summary(study, &rows)? else {
            continue;
        };
        let machine =
            { rows.first() }.map_or(String::new(), |row| format!("{GPU}, {}", row.driver));
        let svg = svg(&summary, &machine);
        write_text(&svg, &folder.join(study.name).with_extension("svg"))?;
    }
    Ok(())
}

/// The settings that have both, or none where there are none.
fn summary(study: &AnyStudy, rows: &[&CostRow]) -> Result<Option<Summary>, FileError> {
    let plugin = study.name;
    let accuracy = Path::new(ROOT).join(ACCURACY);
    let mut summary = (study.summary)(&accuracy)?;
    if plugin == WaveletTex::NAME {
        // What its study summarises is rates, whose code is the same.
        summary.choices = filters(&read::<WaveletTex>(&accuracy)?.rows.tunnel);
        summary.error = Quantity::more("PSNR in the tunnel", "dB", 1);
    }
    let costs = costs(plugin, rows);
    summary
        .choices
        .retain_mut(|choice| match costs.get(choice.name.as_str()) {
            Some(cost) => {
                choice.cost = *cost;
                choice.source != Source::Published
            }
            None => false,
        });
    summary.title = format!("bevy_{plugin}: accuracy against compiled cost");
    summary.cost = Quantity::less(
        "instructions of all its shaders, one map",
        "of Bevy's own",
        2,
    );
    Ok((!summary.choices.is_empty()).then_some(summary))
}

/// PSNR of the filters, and of the hardware's trilinear one over BC7.
fn filters(rows: &[TunnelRow]) -> Vec<Choice> {
    let choices = rows.iter().filter_map(|row| {
        let (name, source) = match row.setting.strip_prefix("color3 ") {
            Some(filter) => (filter, Source::Ours),
            None if row.setting == BEVYS[0] => (BEVYS[0], Source::Baseline),
            None => return None,
        };
        Some(Choice {
            name: name.into(),
            error: row.error?.psnr_db?,
            cost: 0.0,
            source,
        })
    });
    choices.collect()
}

/// What the studies call that which Bevy does alone.
const BEVYS: [&str; 2] = ["bc7 trilinear", "rgba16float"];

/// Instructions of a setting's shaders in the scene with one map, over those of Bevy's material.
fn costs<'a>(plugin: &str, rows: &[&'a CostRow]) -> BTreeMap<&'a str, f64> {
    let mut costs = BTreeMap::from(BEVYS.map(|name| (name, 1.0)));
    let is_one =
        |row: &&&CostRow| row.plugin == plugin && row.material == Scene::BaseColor.material();
    let Some(bevy) = rows
        .iter()
        .filter(is_one)
        .find_map(|row| row.baseline_instructions)
    else {
        return costs;
    };
    for row in rows.iter().filter(is_one) {
        *costs.entry(row.setting.as_str()).or_default() += row.instructions as f64 / bevy as f64;
    }
    costs
}

//! Accuracy, as measured on a software driver, against compiled cost.

use bevy_frugal_lab::ROOT;
use std::{collections::BTreeMap, path::Path};

use super::{
    configurations::PLUGINS,
    error::CostError,
    record::{self, CostRow},
    scene::Scene,
    tables::GPU,
};
use crate::{
    STUDIES, chart,
    record::Report,
    summary::{Better, Choice, Quantity, Source, Summary, means},
};

/// Where accuracy comes from, relative to the repository.
const ACCURACY: &str = "docs/measurements/llvmpipe";

/// Writes one chart a plugin, named as the plugin.
///
/// # Errors
/// [`CostError::File`], naming the path.
pub fn write(rows: &[CostRow], folder: &Path) -> Result<(), CostError> {
    let rows: Vec<_> = rows.iter().filter(|row| row.gpu == GPU).collect();
    for (plugin, _) in PLUGINS {
        let path = Path::new(ROOT).join(ACCURACY).join(plugin);
        let report = record::read_json(&path.with_extension("json"))?;
        let Some(summary) = summary(plugin, &rows, &report) else {
            continue;
        };
        let machine = rows
            .first()
            .map_or(String::new(), |row| format!("{GPU}, {}", row.driver));
        let svg = chart::svg(&summary, &machine);
        record::write_text(&svg, &folder.join(plugin).with_extension("svg"))?;
    }
    Ok(())
}

/// The settings that have both, or none where there are none.
fn summary(plugin: &str, rows: &[&CostRow], report: &Report) -> Option<Summary> {
    let study = STUDIES.iter().find(|study| study.name == plugin)?;
    let mut summary = (study.summary)(report);
    if plugin == "wavelet_tex" {
        // What its study summarises is rates, whose code is the same.
        summary.choices = filters(report);
        summary.error = Quantity {
            name: "PSNR in the tunnel",
            unit: "dB",
            decimals: 1,
            better: Better::More,
            logarithmic_from: None,
        };
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
    summary.cost = Quantity {
        name: "instructions of all its shaders, one map",
        unit: "of Bevy's own",
        decimals: 2,
        better: Better::Less,
        logarithmic_from: None,
    };
    (!summary.choices.is_empty()).then_some(summary)
}

/// PSNR of the filters, and of the hardware's trilinear one over BC7.
fn filters(report: &Report) -> Vec<Choice> {
    let tunnel = report
        .measurements
        .iter()
        .filter(|row| row.scene == "tunnel");
    let quality = means(tunnel, |row| row.psnr_db);
    let choices = quality.into_iter().filter_map(|(name, error)| {
        let (name, source) = match name.strip_prefix("color3 ") {
            Some(filter) => (filter.to_string(), Source::Ours),
            None if name == BEVYS[0] => (name, Source::Baseline),
            None => return None,
        };
        Some(Choice {
            name,
            error,
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

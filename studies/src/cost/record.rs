//! Rows with those of Bevy beside them, in files, and those that may not grow unnoticed: what compiles to more than
//! `TOLERANCE` above the budget needs a change of its file.

use std::path::{Path, PathBuf};

use bevy_frugal_lab::ROOT;
use serde::{Deserialize, Serialize};

use crate::{
    cost::configurations::{Configuration, configurations},
    record::{FileError, read_json, write_json},
};

/// What a shader of a pipeline takes. The baseline is the shader that Bevy alone has for the same material,
/// pass and GPU; a plugin's own pass has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CostRow {
    /// Name of the plugin, or `bevy`.
    pub plugin: String,
    /// Name of the setting.
    pub setting: String,
    /// GPU, as Mesa names it.
    pub gpu: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Name of the material, and of how it is drawn.
    pub material: String,
    /// Name of the pass.
    pub pass: String,
    /// `pixel` or `compute`.
    pub stage: String,
    /// Instructions in the code, however often they run.
    pub instructions: u64,
    /// Vector instructions among them that compute.
    pub valu: u64,
    /// Vector instructions among them that access memory or textures.
    pub vmem: u64,
    /// Vector registers of a thread.
    pub vgprs: u64,
    /// Waves that fit on a SIMD at a time: more hide more latency.
    pub waves: u64,
    /// Local data share of a workgroup in bytes.
    pub lds: u64,
    /// Memory for registers that did not fit, in bytes.
    pub scratch: u64,
    /// Size of the code in bytes.
    pub code_bytes: u64,
    /// Time of the CPU for the whole pipeline, from the composed module on, in milliseconds. It differs
    /// from run to run.
    pub compile_ms: f64,
    /// Bevy's instructions.
    pub baseline_instructions: Option<u64>,
    /// Bevy's vector registers.
    pub baseline_vgprs: Option<u64>,
    /// Bevy's waves.
    pub baseline_waves: Option<u64>,
}

impl CostRow {
    /// Whether it is Bevy's without a plugin.
    pub fn is_baseline(&self) -> bool {
        self.plugin == "bevy" && self.setting == "default"
    }

    fn is_beside(&self, other: &Self) -> bool {
        let place =
            |row: &Self| [&row.gpu, &row.material, &row.pass, &row.stage].map(String::clone);
        place(self) == place(other)
    }
}

/// The rows with Bevy's figures, where it has the same pass.
pub fn beside_bevy(mut rows: Vec<CostRow>) -> Vec<CostRow> {
    let bevys: Vec<_> = rows
        .iter()
        .filter(|row| row.is_baseline())
        .cloned()
        .collect();
    for row in rows.iter_mut().filter(|row| !row.is_baseline()) {
        if let Some(bevy) = bevys.iter().find(|bevy| bevy.is_beside(row)) {
            row.baseline_instructions = Some(bevy.instructions);
            row.baseline_vgprs = Some(bevy.vgprs);
            row.baseline_waves = Some(bevy.waves);
        }
    }
    rows
}

/// Where the committed figures are, relative to the repository.
pub const FOLDER: &str = "docs/measurements/radv";
const FILE: &str = "cost.json";

/// Reads `cost.json` of a folder.
pub fn read(folder: &Path) -> Result<Vec<CostRow>, FileError> {
    read_json(&folder.join(FILE))
}

/// The rows in a folder, if there are any, with new ones in the place of those of the same GPU and plugin, in the order
/// of plugins and GPUs.
pub fn renewed(folder: &Path, new: Vec<CostRow>) -> Result<Vec<CostRow>, FileError> {
    let mut rows = match folder.join(FILE).exists() {
        true => read(folder)?,
        false => Vec::new(),
    };
    let is_kept = |row: &CostRow| {
        let mut new = new.iter();
        !new.any(|new| (&new.gpu, &new.plugin) == (&row.gpu, &row.plugin))
    };
    rows.retain(is_kept);
    rows.extend(new);
    // The same order whichever plugin was measured last.
    rows.sort_by(|a, b| (&a.plugin, &a.gpu).cmp(&(&b.plugin, &b.gpu)));
    Ok(rows)
}

/// Writes `cost.json` into a folder.
pub fn write(rows: &[CostRow], folder: &Path) -> Result<(), FileError> {
    write_json(&rows, &folder.join(FILE))
}

/// The share by which a figure may grow.
const TOLERANCE: f64 = 0.03;

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// The version of Mesa: another one compiles to other code.
    pub mesa: String,
    /// The GPU, as Mesa names it.
    pub gpu: String,
    /// The rows.
    pub rows: Vec<BudgetRow>,
}

/// The most that a shader may take; the fields are those of [`CostRow`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BudgetRow {
    pub plugin: String,
    pub setting: String,
    pub material: String,
    pub pass: String,
    pub instructions: u64,
    pub vgprs: u64,
}

impl Budget {
    /// Reads the committed file.
    pub fn read() -> Result<Self, FileError> {
        read_json(&path())
    }

    /// Writes the committed file.
    pub fn write(&self) -> Result<(), FileError> {
        write_json(self, &path())
    }

    /// The configurations that have its rows, with no other scenes.
    pub fn configurations(&self) -> Vec<Configuration> {
        let mut all = configurations();
        for c in &mut all {
            let rows = self
                .rows
                .iter()
                .filter(|r| r.plugin == c.plugin && r.setting == c.setting);
            let materials: Vec<_> = rows.map(|row| &row.material).collect();
            c.scenes
                .retain(|scene| materials.iter().any(|name| *name == scene.material()));
        }
        all.retain(|c| !c.scenes.is_empty());
        all
    }

    /// The same rows with the figures of others; those that are not among them are gone.
    pub fn renewed(&self, rows: &[CostRow]) -> Self {
        let renewed = self.rows.iter().filter_map(|row| {
            let found = rows
                .iter()
                .find(|found| found.gpu == self.gpu && row.is_of(found))?;
            Some(BudgetRow {
                instructions: found.instructions,
                vgprs: found.vgprs,
                ..row.clone()
            })
        });
        Self {
            rows: renewed.collect(),
            ..self.clone()
        }
    }

    /// What is above it or was not compiled, a line each.
    pub fn exceeded_by(&self, rows: &[CostRow]) -> Vec<String> {
        self.rows
            .iter()
            .filter_map(|row| row.exceeded_by(rows))
            .collect()
    }
}

impl BudgetRow {
    fn is_of(&self, row: &CostRow) -> bool {
        let own = [&self.plugin, &self.setting, &self.material, &self.pass];
        own == [&row.plugin, &row.setting, &row.material, &row.pass]
    }

    fn exceeded_by(&self, rows: &[CostRow]) -> Option<String> {
        let name = [&*self.plugin, &self.setting, &self.material, &self.pass].join(", ");
        let Some(found) = rows.iter().find(|row| self.is_of(row)) else {
            return Some(format!("{name}: not compiled"));
        };
        let figures = [
            ("instructions", found.instructions, self.instructions),
            ("VGPRs", found.vgprs, self.vgprs),
        ];
        let above = figures
            .into_iter()
            .filter(|(_, now, most)| *now as f64 > *most as f64 * (1.0 + TOLERANCE));
        let above: Vec<_> = above
            .map(|(what, now, most)| format!("{now} {what}, budget {most}"))
            .collect();
        (!above.is_empty()).then(|| format!("{name}: {}", above.join("; ")))
    }
}

fn path() -> PathBuf {
    Path::new(ROOT).join(FOLDER).join("budget.json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_bevys_figures_of_the_same_place_beside_it() {
        let row = |plugin: &str, pass: &str, instructions| CostRow {
            plugin: plugin.into(),
            setting: "default".into(),
            pass: pass.into(),
            instructions,
            ..CostRow::default()
        };
        let rows = vec![
            row("ewa", "forward", 9),
            row("bevy", "forward", 3),
            row("ewa", "own", 1),
        ];
        let found = beside_bevy(rows);
        let baselines: Vec<_> = found.iter().map(|row| row.baseline_instructions).collect();
        assert_eq!(baselines, [Some(3), None, None]);
    }

    #[test]
    fn new_rows_replace_those_of_the_same_gpu_and_plugin() {
        let row = |gpu: &str, plugin: &str, instructions| CostRow {
            gpu: gpu.into(),
            plugin: plugin.into(),
            instructions,
            ..CostRow::default()
        };
        let folder = std::env::temp_dir().join(format!("cost-{}", std::process::id()));
        let none = renewed(&folder, Vec::new()).expect("no rows");
        assert!(none.is_empty());
        let old = [
            row("navi31", "ewa", 1),
            row("navi21", "ewa", 2),
            row("navi21", "bevy", 3),
        ];
        write(&old, &folder).expect("written");
        let found = renewed(&folder, vec![row("navi21", "ewa", 4)]).expect("read");
        std::fs::remove_dir_all(&folder).expect("removed");
        let instructions: Vec<_> = found.iter().map(|row| row.instructions).collect();
        // In the order of plugins, then of GPUs.
        assert_eq!(instructions, [3, 4, 1]);
    }

    #[test]
    fn growth_of_more_than_the_tolerance_is_named() {
        let row = |instructions, vgprs| CostRow {
            plugin: "ewa".into(),
            gpu: "navi31".into(),
            instructions,
            vgprs,
            ..CostRow::default()
        };
        let budget = Budget {
            mesa: String::new(),
            gpu: "navi31".into(),
            rows: vec![BudgetRow {
                plugin: "ewa".into(),
                setting: String::new(),
                material: String::new(),
                pass: String::new(),
                instructions: 1000,
                vgprs: 96,
            }],
        };
        assert!(budget.exceeded_by(&[row(1030, 96)]).is_empty());
        assert_eq!(budget.exceeded_by(&[row(1031, 96)]).len(), 1);
        assert!(budget.exceeded_by(&[row(900, 108)])[0].ends_with("108 VGPRs, budget 96"));
        assert!(budget.exceeded_by(&[])[0].contains("not compiled"));
        assert_eq!(budget.renewed(&[row(900, 84)]).rows[0].vgprs, 84);
    }

    #[test]
    fn every_row_of_the_file_is_compiled() {
        let budget = Budget::read().expect("the committed budget");
        let configurations = budget.configurations();
        for row in &budget.rows {
            let found = configurations.iter().any(|c| {
                let materials: Vec<_> = c.scenes.iter().map(|scene| scene.material()).collect();
                c.plugin == row.plugin
                    && c.setting == row.setting
                    && materials.contains(&&*row.material)
            });
            assert!(found, "{row:?}");
        }
    }
}

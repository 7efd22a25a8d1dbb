//! Rows that may not grow unnoticed: their instructions and registers are in a file, and what compiles to
//! more than `TOLERANCE` above it needs a change of the file.

use bevy_frugal_lab::ROOT;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{
    configurations::{Configuration, configurations},
    error::CostError,
    record::{self, CostRow, FOLDER},
};

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
    ///
    /// # Errors
    /// [`CostError::File`].
    pub fn read() -> Result<Self, CostError> {
        record::read_json(&path())
    }

    /// Writes the committed file.
    ///
    /// # Errors
    /// [`CostError::File`].
    pub fn write(&self) -> Result<(), CostError> {
        record::write_json(self, &path())
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

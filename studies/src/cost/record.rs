//! Rows with those of Bevy beside them, in files.

use std::{fmt::Write, path::Path};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::error::CostError;

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

/// Columns of the CSV, which are the fields of a row.
const COLUMNS: [&str; 19] = [
    "plugin",
    "setting",
    "gpu",
    "driver",
    "material",
    "pass",
    "stage",
    "instructions",
    "valu",
    "vmem",
    "vgprs",
    "waves",
    "lds",
    "scratch",
    "code_bytes",
    "compile_ms",
    "baseline_instructions",
    "baseline_vgprs",
    "baseline_waves",
];

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
///
/// # Errors
/// [`CostError::File`], naming the path.
pub fn read(folder: &Path) -> Result<Vec<CostRow>, CostError> {
    read_json(&folder.join(FILE))
}

/// The rows in a folder, if there are any, with new ones in the place of those of the same GPU and plugin, in the order
/// of plugins and GPUs.
///
/// # Errors
/// [`CostError::File`], naming the path.
pub fn renewed(folder: &Path, new: Vec<CostRow>) -> Result<Vec<CostRow>, CostError> {
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

/// Writes `cost.json` and `cost.csv` into a folder, which is made where it is missing.
///
/// # Errors
/// [`CostError::File`], naming the path.
pub fn write(rows: &[CostRow], folder: &Path) -> Result<(), CostError> {
    write_json(&rows, &folder.join(FILE))?;
    write_text(&csv(rows), &folder.join("cost.csv"))
}

fn csv(rows: &[CostRow]) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for row in rows {
        let row = serde_json::json!(row);
        let cells = COLUMNS.map(|column| match &row[column] {
            Value::Null => String::new(),
            value => value.to_string(),
        });
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

pub(super) fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, CostError> {
    let json = std::fs::read(path).and_then(|json| Ok(serde_json::from_slice(&json)?));
    json.map_err(|source| CostError::File {
        path: path.into(),
        source,
    })
}

pub(super) fn write_json<T: Serialize>(value: &T, path: &Path) -> Result<(), CostError> {
    let json = serde_json::to_string_pretty(value);
    let json = json.map_err(|error| CostError::File {
        path: path.into(),
        source: error.into(),
    })?;
    write_text(&(json + "\n"), path)
}

pub(super) fn write_text(text: &str, path: &Path) -> Result<(), CostError> {
    let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    let written = made.and_then(|()| std::fs::write(path, text));
    written.map_err(|source| CostError::File {
        path: path.into(),
        source,
    })
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
        let text = csv(&found);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 4);
        assert_eq!(
            lines[1],
            r#""ewa","default","","","","forward","",9,0,0,0,0,0,0,0,0.0,3,0,0"#
        );
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
    fn every_field_is_a_column() {
        let row = serde_json::json!(CostRow::default());
        let fields: Vec<_> = row
            .as_object()
            .expect("an object")
            .keys()
            .map(String::as_str)
            .collect();
        assert_eq!(fields.len(), COLUMNS.len());
        assert!(fields.iter().all(|field| COLUMNS.contains(field)));
    }
}

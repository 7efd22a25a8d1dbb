//! What Mesa's AMD driver prints of shaders (`RADV_DEBUG=shaderstats`), between marks of ours.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::record::CostRow;

/// What marks begin with.
const MARK: &str = "cost: ";

/// A line between the driver's, which says what it prints next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mark {
    /// The driver's name and version.
    Driver(String),
    /// A pipeline is compiled from here on.
    Begin {
        /// Name of the plugin.
        plugin: String,
        /// Name of the setting.
        setting: String,
        /// Name of the scene's material.
        material: String,
        /// Name of the pass.
        pass: String,
    },
    /// It took this many milliseconds.
    End(f64),
}

impl Mark {
    /// Writes the mark where the driver writes.
    pub fn print(&self) {
        // A mark is only strings and finite numbers.
        eprintln!("\n{MARK}{}", serde_json::json!(self));
    }
}

/// The pixel and compute shaders of a log, with the names in the marks around them.
pub fn rows(gpu: &str, log: &str) -> Vec<CostRow> {
    let mut rows = Vec::new();
    let mut driver = String::new();
    let mut shaders = Vec::new();
    let mut name = None;
    for line in log.lines() {
        if let Some(mark) = line.strip_prefix(MARK) {
            match serde_json::from_str(mark) {
                Ok(Mark::Driver(name)) => driver = name,
                Ok(Mark::End(ms)) => {
                    let found = shaders
                        .drain(..)
                        .filter_map(|s| row(name.as_ref()?, &s, ms));
                    rows.extend(found.map(|row| CostRow {
                        gpu: gpu.into(),
                        driver: driver.clone(),
                        ..row
                    }));
                    name = None;
                }
                Ok(begin) => {
                    shaders.clear();
                    name = Some(begin);
                }
                Err(_) => name = None,
            }
        } else if let Some((stage, "")) = line.split_once(" Shader:") {
            shaders.push(Shader {
                stage: stage.to_lowercase(),
                figures: BTreeMap::new(),
            });
        } else if let (Some(shader), Some((key, value))) =
            (shaders.last_mut(), line.split_once(": "))
            && let Ok(value) = value.trim().parse()
        {
            shader.figures.insert(key.to_string(), value);
        }
    }
    rows
}

struct Shader {
    stage: String,
    figures: BTreeMap<String, u64>,
}

fn row(name: &Mark, shader: &Shader, compile_ms: f64) -> Option<CostRow> {
    let Mark::Begin {
        plugin,
        setting,
        material,
        pass,
    } = name
    else {
        return None;
    };
    if shader.stage != "pixel" && shader.stage != "compute" {
        return None;
    }
    let figure = |key: &str| shader.figures.get(key).copied();
    Some(CostRow {
        plugin: plugin.clone(),
        setting: setting.clone(),
        material: material.clone(),
        pass: pass.clone(),
        stage: shader.stage.clone(),
        instructions: figure("Instructions")?,
        valu: figure("VALU")?,
        vmem: figure("VMEM")?,
        vgprs: figure("VGPRs")?,
        waves: figure("Subgroups per SIMD")?,
        lds: figure("LDS size")?,
        scratch: figure("Scratch size")?,
        code_bytes: figure("Code size")?,
        compile_ms: (compile_ms * 10.0).round() / 10.0,
        ..CostRow::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXEL: &str = "Pixel Shader:\n*** SHADER STATS ***\nDriver pipeline hash: 1\nVGPRs: 72\n\
        Code size: 800\nLDS size: 0\nScratch size: 4\nSubgroups per SIMD: 20\nInstructions: 100\n\
        VALU: 60\nVMEM: 7\n********************\n";

    #[test]
    fn a_row_has_the_name_in_the_marks_around_it() {
        let begin = Mark::Begin {
            plugin: "ewa".into(),
            setting: "linear".into(),
            material: "base colour".into(),
            pass: "forward".into(),
        };
        let mark = |mark: &Mark| format!("{MARK}{}\n", serde_json::json!(mark));
        let vertex = PIXEL.replace("Pixel", "Vertex");
        let log = [
            mark(&Mark::Driver("radv".into())),
            // Bevy's own compiling, outside of marks.
            PIXEL.replace("100", "5"),
            mark(&begin),
            vertex,
            PIXEL.into(),
            mark(&Mark::End(1.26)),
            PIXEL.replace("100", "6"),
        ];
        let found = rows("navi31", &log.concat());
        let [row] = &found[..] else {
            panic!("{found:?}")
        };
        assert_eq!(
            [&*row.driver, &row.setting, &row.stage],
            ["radv", "linear", "pixel"]
        );
        assert_eq!(
            (row.instructions, row.vgprs, row.waves, row.scratch),
            (100, 72, 20, 4)
        );
        assert_eq!(row.compile_ms, 1.3);
    }
}

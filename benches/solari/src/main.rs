//! `bevy_voxel_gi`, Bevy's `bevy_solari`, and what needs neither, beside path tracing.
//!
//! Each draws the three traced scenes of boxes with a still camera. The whole picture is compared, since
//! `bevy_solari` draws direct and indirect light at once: means of 4 x 4 pixels with those of the path-traced
//! light, as the study of `bevy_voxel_gi` compares them.
//!
//! | file | what it does |
//! | --- | --- |
//! | `method.rs` | the methods that draw the light, by name |
//! | `measure.rs` | runs its frames and compares them |
//! | `convert.rs` | gives a scene what `bevy_solari` needs |
//! | `picture.rs` | pictures in floats |
//! | `ambient.rs` | the best constant ambient light |

mod ambient;
mod convert;
mod measure;
mod method;
mod picture;

use std::{error::Error, path::PathBuf, time::SystemTime};

use bevy_frugal_lab::{
    boxes::TracedScene,
    record::{Measurement, Report},
};
use clap::Parser;

use method::Method;

/// Measures global illumination in Bevy beside path tracing; prints a table.
#[derive(Parser)]
struct Arguments {
    /// Folder in which `solari.json` is written; none is written without it.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Scenes to draw.
    #[arg(long, num_args = 1.., default_values_t = TracedScene::NAMES.map(String::from))]
    scenes: Vec<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let mut report = Report {
        date: now.split('T').next().unwrap_or_default().into(),
        ..Report::default()
    };
    println!("| scene | setting | error | bias | flicker | ms a frame |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for name in &arguments.scenes {
        let scene = TracedScene::read(name)?;
        for method in Method::ALL.into_iter().filter(|m| m.draws(&scene.scene)) {
            let (rows, adapter) = measure::rows(&scene, method)?;
            rows.iter().for_each(print);
            report.measurements.extend(rows);
            report.adapter = adapter;
        }
    }
    if let Some(folder) = arguments.out {
        report.write(folder.join("solari.json"))?;
    }
    Ok(())
}

fn print(row: &Measurement) {
    let percent =
        |value: Option<f64>| value.map_or(String::new(), |v| format!("{:.1}%", 100.0 * v));
    println!(
        "| {} | {} | {} | {} | {} | {:.0} |",
        row.scene,
        row.setting,
        percent(row.relative_error),
        percent(row.bias),
        percent(row.flicker),
        row.cpu_ms.unwrap_or_default(),
    );
}

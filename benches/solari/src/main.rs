//! `bevy_voxel_gi`, Bevy's `bevy_solari`, what is baked, and what needs none of these, beside path tracing.
//!
//! Each draws the three traced scenes of boxes with a still camera. The whole picture is compared, since
//! `bevy_solari` draws direct and indirect light at once: means of 4 x 4 pixels with those of the path-traced
//! light, as the study of `bevy_voxel_gi` compares them.
//!
//! | file | what it does |
//! | --- | --- |
//! | `method.rs` | the methods that draw the light, by name |
//! | `measure.rs` | runs its frames, with the best constant ambient light, and compares them |
//! | `bake.rs` | what bakes share: memory and time, light for texels and voxels that boxes cover, textures |
//! | `lightmap.rs` | path-traced lightmaps |
//! | `atlas.rs` | the layout of a lightmap |
//! | `irradiance_volume.rs` | path-traced irradiance volumes |
//! | `convert.rs` | gives a scene what `bevy_solari` needs |

mod atlas;
mod bake;
mod convert;
mod irradiance_volume;
mod lightmap;
mod measure;
mod method;

use std::{error::Error, path::PathBuf};

use bevy_frugal_lab::boxes::TracedScene;
use bevy_frugal_studies::{
    record::Report,
    voxel_gi::{LightRow, Rows},
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
    /// Methods to measure, by name; all without it.
    #[arg(long, num_args = 1..)]
    methods: Vec<String>,
    /// Folder in which the last picture of each method is written, and what that adds.
    #[arg(long)]
    pictures: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let mut report = Report::<Rows>::default().of_today();
    println!("| scene | setting | error | bias | flicker | ms a frame |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for name in &arguments.scenes {
        let scene = TracedScene::read(name)?;
        let is_wanted = |method: &Method| {
            let methods = &arguments.methods;
            methods.is_empty() || methods.iter().any(|name| name == method.name())
        };
        let methods = Method::ALL.into_iter().filter(is_wanted);
        for method in methods.filter(|method| method.draws(&scene.scene)) {
            let (rows, adapter) = measure::rows(&scene, method, arguments.pictures.as_deref())?;
            rows.iter().for_each(print);
            report.rows.boxes.extend(rows);
            report.adapter = adapter;
        }
    }
    if let Some(folder) = arguments.out {
        report.write(folder.join("solari.json"))?;
    }
    Ok(())
}

fn print(row: &LightRow) {
    let percent =
        |value: Option<f64>| value.map_or(String::new(), |v| format!("{:.1}%", 100.0 * v));
    println!(
        "| {} | {} | {} | {} | {} | {:.0} |",
        row.scene,
        row.setting,
        percent(row.relative_error),
        percent(row.bias),
        percent(row.flicker),
        row.times.cpu_ms.unwrap_or_default(),
    );
}

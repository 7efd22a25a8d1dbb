//! What a pixel fetches, counted by its own shader: the pixel shader of an app is composed as Bevy does, made
//! to count ([`super::counting`]), and put in the place of the original, and the picture is read back. Loops and
//! branches count as often as they run, on a floor that is seen from near and far.

use std::{collections::BTreeSet, path::Path};

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        render_resource::{CachedPipelineState, PipelineCache, PipelineDescriptor},
        renderer::RenderDevice,
    },
    shader::{Shader, ShaderDefVal},
};
use bevy_frugal_lab::{
    ROOT,
    compose::{Composer, device_defs},
    headless::HeadlessApp,
};
use serde::{Deserialize, Serialize};

use crate::{
    cost::{
        CostError,
        app::floor_app,
        configurations::{Configuration, Scene, configurations},
        counting::{KINDS, counting},
        pipelines::pass,
    },
    page::table,
    record::{FileError, read_json, write_json},
};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;
/// Frames whose mean is taken: some settings fetch different texels in even and odd frames.
const FRAMES: u32 = 2;
/// The pass of the plugin that is no material's, and is counted too.
const RESOLVE: &str = "packed_ycocg_resolve";

/// Counts the fetches of a plugin, or of all, and writes them into a folder beside those of the others.
pub fn measure(plugin: Option<&str>, folder: &Path) -> Result<(), CostError> {
    let is_selected = |name: &str| name == "bevy" || plugin.is_none_or(|plugin| plugin == name);
    let path = folder.join(FILE);
    let mut rows: Vec<FetchRow> = match path.exists() {
        true => read_json(&path)?,
        false => Vec::new(),
    };
    rows.retain(|row| !is_selected(&row.plugin));
    for configuration in configurations() {
        if !is_selected(configuration.plugin) || !configuration.changes_pixels() {
            continue;
        }
        for scene in [Scene::BaseColor, Scene::FiveMaps] {
            // The resolve depends on no material.
            let is_same = configuration.plugin == "ycocg_fb" && scene != Scene::BaseColor;
            if configuration.scenes.contains(&scene) && !is_same {
                let row = counted(&configuration, scene)?;
                println!(
                    "{}, {}: {:.1}",
                    configuration.name(),
                    row.material,
                    row.fetches()
                );
                rows.push(row);
            }
        }
    }
    Ok(write_json(&beside_bevy(rows), &path)?)
}

fn beside_bevy(mut rows: Vec<FetchRow>) -> Vec<FetchRow> {
    let is_bevys = |row: &&FetchRow| row.plugin == "bevy" && row.setting == "default";
    let bevys: Vec<_> = rows.iter().filter(is_bevys).cloned().collect();
    for row in &mut rows {
        let mut same = bevys
            .iter()
            .filter(|bevy| bevy.material == row.material && bevy.pass == row.pass);
        row.baseline_fetches = same.next().map(FetchRow::fetches);
    }
    rows
}

/// The fetches of a configuration in a scene.
pub fn counted(configuration: &Configuration, scene: Scene) -> Result<FetchRow, CostError> {
    let mut app = floor_app(&configuration.kind, scene)?;
    app.run_until_ready(MAX_FRAMES)?;
    let pass = if configuration.plugin == "ycocg_fb" {
        RESOLVE
    } else {
        "forward"
    };
    let failed = |text: String| {
        CostError::Failed(format!(
            "{}, {}: {text}",
            configuration.name(),
            scene.material()
        ))
    };
    let (id, mut defs) = shader(&mut app, pass).ok_or_else(|| failed(format!("no pass {pass}")))?;
    defs.extend(device_defs(app.world().resource::<RenderDevice>()));
    let source = Composer::new(app.world())
        .compose(id, &defs)
        .map_err(failed)?;
    let counting = counting(&source).map_err(failed)?;
    // Pipelines of earlier frames have the shader, too, which may read a texture that their layout lacks. They are
    // refused, and draw nothing.
    app.world_mut()
        .insert_resource(RenderErrorHandler(|_, _, _| RenderErrorPolicy::Ignore));
    let render_world = app.app_mut().sub_app_mut(RenderApp).world_mut();
    let mut cache = render_world.resource_mut::<PipelineCache>();
    cache.set_shader(id, Shader::from_wgsl(counting, "counting.wgsl"));
    let mut sums = [0.0; KINDS.len()];
    for _ in 0..FRAMES {
        app.render_frames(1)?;
        let picture = app.capture_f32()?;
        let each = 1.0 / (f64::from(FRAMES) * picture.pixels.len() as f64);
        for pixel in &picture.pixels {
            if pixel.iter().any(|count| count.fract() != 0.0) {
                return Err(failed(format!("no counts but {pixel:?}")));
            }
            for (sum, count) in sums.iter_mut().zip(pixel) {
                *sum += f64::from(*count) * each;
            }
        }
    }
    let [samples, loads, gathers, comparisons] = sums.map(|sum| (sum * 100.0).round() / 100.0);
    Ok(FetchRow {
        plugin: configuration.plugin.into(),
        setting: configuration.setting.clone(),
        material: scene.material().into(),
        pass: pass.into(),
        samples,
        loads,
        gathers,
        comparisons,
        baseline_fetches: None,
    })
}

/// The pixel shader that a pass is drawn with.
fn shader(app: &mut HeadlessApp, name: &str) -> Option<(AssetId<Shader>, Vec<ShaderDefVal>)> {
    let cache = app
        .app_mut()
        .sub_app(RenderApp)
        .world()
        .resource::<PipelineCache>();
    let pipelines: Vec<_> = cache.pipelines().collect();
    // The last one is what the pass is drawn with, as `pipelines` says.
    let found = pipelines.into_iter().rev().find(|pipeline| {
        matches!(pipeline.state, CachedPipelineState::Ok(_))
            && pass(&pipeline.descriptor).is_some_and(|pass| pass == name)
    })?;
    let PipelineDescriptor::RenderPipelineDescriptor(descriptor) = &found.descriptor else {
        return None;
    };
    let fragment = descriptor.fragment.as_ref()?;
    Some((fragment.shader.id(), fragment.shader_defs.clone()))
}

/// Where the committed figures are, relative to the repository.
pub const FOLDER: &str = "docs/measurements/llvmpipe";
/// Name of the file in its folder.
pub const FILE: &str = "fetches.json";

/// The mean number of fetches of a pixel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FetchRow {
    /// Name of the plugin, or `bevy`.
    pub plugin: String,
    /// Name of the setting.
    pub setting: String,
    /// Name of the material.
    pub material: String,
    /// Name of the pass.
    pub pass: String,
    /// Fetches through a filter.
    pub samples: f64,
    /// Fetches of one texel.
    pub loads: f64,
    /// Fetches of one component of four texels.
    pub gathers: f64,
    /// Comparisons with the depth in a shadow map.
    pub comparisons: f64,
    /// Fetches of all kinds by Bevy alone, where it has the pass.
    pub baseline_fetches: Option<f64>,
}

impl FetchRow {
    /// Fetches of all kinds.
    pub fn fetches(&self) -> f64 {
        self.samples + self.loads + self.gathers + self.comparisons
    }
}

/// Reads the committed figures.
pub fn read() -> Result<Vec<FetchRow>, FileError> {
    let root = Path::new(ROOT);
    read_json(&root.join(FOLDER).join(FILE))
}

/// The table of a plugin's page: fetches of a pixel by setting.
pub fn page(rows: &[FetchRow], plugin: &str) -> String {
    let mut settings = BTreeSet::new();
    let own: Vec<_> = rows.iter().filter(|row| row.plugin == plugin).collect();
    let scenes: Vec<_> = [Scene::BaseColor, Scene::FiveMaps]
        .into_iter()
        .filter(|scene| own.iter().any(|row| row.material == scene.material()))
        .collect();
    let names: Vec<_> = scenes.iter().map(|scene| scene.material()).collect();
    let mut lines = Vec::new();
    let mut line = |name: &str, plugin: &str, setting: &str| {
        let cells: Vec<_> = { names.iter() }
            .map(|material| {
                let is_it = |row: &&FetchRow| {
                    row.plugin == plugin && row.setting == setting && row.material == *material
                };
                rows.iter().find(is_it).map_or(String::new(), cell)
            })
            .collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            lines.push([vec![name.into()], cells].concat());
        }
    };
    if own.iter().any(|row| row.baseline_fetches.is_some()) {
        line("Bevy alone", "bevy", "default");
    }
    if plugin == "voxel_gi" {
        line("Bevy's own irradiance volume", "bevy", "irradiance_volume");
    }
    for row in own.iter().filter(|row| settings.insert(&row.setting)) {
        line(&format!("`{}`", row.setting), plugin, &row.setting);
    }
    table(&[&["setting"], &names[..]].concat(), lines)
}

/// All fetches, and over Bevy's; then by kind.
fn cell(row: &FetchRow) -> String {
    let fetches = row.fetches();
    let factor = { row.baseline_fetches.filter(|_| row.plugin != "bevy") }
        .map_or(String::new(), |bevy| format!(" ({:.1})", fetches / bevy));
    let kinds = [row.samples, row.loads, row.gathers, row.comparisons];
    let kinds = kinds.map(|count| format!("{count:.1}"));
    format!("{fetches:.1}{factor}: {}", kinds.join(" + "))
}

//! What a pixel fetches, counted by its own shader: the pixel shader of an app is composed as Bevy does, made
//! to count ([`mod@counting`]), and put in the place of the original, and the picture is read back. Loops and
//! branches count as often as they run, on a floor that is seen from near and far.

pub mod counting;
mod floor;
pub mod record;
pub mod tables;

use std::path::Path;

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

use self::{
    counting::{KINDS, counting},
    record::{FILE, FetchRow},
};
use super::{
    configurations::{Configuration, configurations},
    error::CostError,
    pipelines::pass,
    record::{read_json, write_json},
    scene::Scene,
};
use bevy_frugal_lab::{
    compose::{Composer, device_defs},
    headless::HeadlessApp,
};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;
/// Frames whose mean is taken: some settings fetch different texels in even and odd frames.
const FRAMES: u32 = 2;
/// The pass of the plugin that is no material's, and is counted too.
const RESOLVE: &str = "packed_ycocg_resolve";

/// Counts the fetches of a plugin, or of all, and writes them into a folder beside those of the others.
///
/// # Errors
/// [`CostError`].
pub fn measure(plugin: Option<&str>, folder: &Path) -> Result<(), CostError> {
    let is_wanted = |name: &str| name == "bevy" || plugin.is_none_or(|wanted| wanted == name);
    let path = folder.join(FILE);
    let mut rows: Vec<FetchRow> = match path.exists() {
        true => read_json(&path)?,
        false => Vec::new(),
    };
    rows.retain(|row| !is_wanted(&row.plugin));
    for configuration in configurations() {
        if !is_wanted(configuration.plugin) || !configuration.changes_pixels() {
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
    write_json(&beside_bevy(rows), &path)
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
///
/// # Errors
/// [`CostError`].
pub fn counted(configuration: &Configuration, scene: Scene) -> Result<FetchRow, CostError> {
    let mut app = floor::app(&configuration.kind, scene)?;
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
fn shader(app: &mut HeadlessApp, wanted: &str) -> Option<(AssetId<Shader>, Vec<ShaderDefVal>)> {
    let cache = app
        .app_mut()
        .sub_app(RenderApp)
        .world()
        .resource::<PipelineCache>();
    let pipelines: Vec<_> = cache.pipelines().collect();
    // The last one is what the pass is drawn with, as `pipelines` says.
    let found = pipelines.into_iter().rev().find(|pipeline| {
        matches!(pipeline.state, CachedPipelineState::Ok(_))
            && pass(&pipeline.descriptor).is_some_and(|pass| pass == wanted)
    })?;
    let PipelineDescriptor::RenderPipelineDescriptor(descriptor) = &found.descriptor else {
        return None;
    };
    let fragment = descriptor.fragment.as_ref()?;
    Some((fragment.shader.id(), fragment.shader_defs.clone()))
}

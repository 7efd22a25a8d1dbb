//! Every pipeline of an app, compiled between marks.
//!
//! The driver prints the cost of a shader when it compiles it, without a name. An app compiles its
//! pipelines as it needs them, in any order; once it needs no more, those of interest are queued again
//! in Bevy's `PipelineCache`, one at a time, and the cache compiles each before the next is queued.
//! Shader modules are composed and validated only once, so the time is that of SPIR-V and the driver.

use std::{
    collections::BTreeMap,
    process::Command,
    time::{Duration, Instant},
};

use bevy::render::{
    RenderApp,
    render_resource::{CachedPipelineState, FragmentState, PipelineCache, PipelineDescriptor},
};

use super::{
    app::app,
    configurations::Configuration,
    error::CostError,
    record::CostRow,
    scene::Scene,
    shim,
    statistics::{self, Mark},
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessError};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 600;
/// Frames in a row without a new pipeline after which none is expected any more: what a plugin extracts
/// takes a few frames until something is drawn with it.
const QUIET_FRAMES: u32 = 5;

/// Bevy's pass that maps scene-linear colours to those of a display.
pub const TONE_MAPPING: &str = "tone mapping";
/// Bevy's pass that copies a picture.
pub const COPY: &str = "copy";

/// Compiles what `program` compiles with [`print()`] when it is started under the driver.
///
/// # Errors
/// As of [`shim::run`].
pub fn compile(
    gpu: &str,
    program: &Command,
    configurations: &[Configuration],
) -> Result<Vec<CostRow>, CostError> {
    let parts = configurations.iter().map(Configuration::name);
    let mut rows = Vec::new();
    for output in shim::run(gpu, program, parts)? {
        rows.extend(statistics::rows(
            gpu,
            &String::from_utf8_lossy(&output?.stderr),
        ));
    }
    Ok(rows)
}

/// Compiles the configuration that this process is to compile, and prints marks.
///
/// # Errors
/// [`CostError::App`] where an app cannot be built, [`CostError::Failed`] where it has no pipeline of
/// interest.
pub fn print(configurations: &[Configuration]) -> Result<(), CostError> {
    let part = shim::part();
    for configuration in configurations.iter().filter(|c| c.name() == part) {
        for &scene in &configuration.scenes {
            let mut app = app(configuration, scene)?;
            settle(&mut app)?;
            Mark::Driver(app.adapter().driver.clone()).print();
            compile_again(&mut app, configuration, scene)?;
        }
    }
    Ok(())
}

/// Runs frames until no new pipeline has been asked for in a while.
pub fn settle(app: &mut HeadlessApp) -> Result<(), HeadlessError> {
    let (mut quiet, mut count) = (0, 0);
    for _ in 0..MAX_FRAMES {
        app.app_mut().update();
        app.check_pipelines()?;
        let cache = app
            .app_mut()
            .sub_app(RenderApp)
            .world()
            .resource::<PipelineCache>();
        let is_ok = |state: &CachedPipelineState| matches!(state, CachedPipelineState::Ok(_));
        let is_ready = cache.pipelines().all(|pipeline| is_ok(&pipeline.state));
        let new_count = cache.pipelines().count();
        quiet = if is_ready && new_count == count {
            quiet + 1
        } else {
            0
        };
        count = new_count;
        if quiet == QUIET_FRAMES {
            return Ok(());
        }
        // Shaders load on other threads.
        std::thread::sleep(Duration::from_millis(1));
    }
    Err(HeadlessError::NotReady {
        frames: MAX_FRAMES,
        waiting: vec!["pipelines".into()],
    })
}

fn compile_again(
    app: &mut HeadlessApp,
    configuration: &Configuration,
    scene: Scene,
) -> Result<(), CostError> {
    let world = app.app_mut().sub_app_mut(RenderApp).world_mut();
    let mut cache = world.resource_mut::<PipelineCache>();
    // Before a plugin has extracted what it needs, a pass may have been drawn without it: the last
    // pipeline of a pass is the one that it is drawn with from then on.
    let passes: BTreeMap<_, _> = cache
        .pipelines()
        .enumerate()
        .filter_map(|(id, pipeline)| Some((pass(&pipeline.descriptor)?, id)))
        .collect();
    if passes.is_empty() {
        let text = format!(
            "{}, {}: no pipeline",
            configuration.name(),
            scene.material()
        );
        return Err(CostError::Failed(text));
    }
    for (pass, id) in passes {
        // It depends on neither plugin nor material.
        let is_bevys = [TONE_MAPPING, COPY].contains(&pass.as_str());
        if is_bevys && (configuration.plugin, scene) != ("bevy", Scene::BaseColor) {
            continue;
        }
        match cache
            .pipelines()
            .nth(id)
            .map(|pipeline| &pipeline.descriptor)
        {
            Some(PipelineDescriptor::RenderPipelineDescriptor(descriptor)) => {
                cache.queue_render_pipeline((**descriptor).clone());
            }
            Some(PipelineDescriptor::ComputePipelineDescriptor(descriptor)) => {
                cache.queue_compute_pipeline((**descriptor).clone());
            }
            _ => continue,
        }
        let begin = Mark::Begin {
            plugin: configuration.plugin.into(),
            setting: configuration.setting.clone(),
            material: scene.material().into(),
            pass,
        };
        begin.print();
        let start = Instant::now();
        cache.process_queue();
        Mark::End(start.elapsed().as_secs_f64() * 1e3).print();
    }
    Ok(())
}

/// The name of a pass of interest: one that draws the scene's material, or lights it, tone-maps or copies the
/// picture, or one of a plugin. A pipeline without a pixel shader is none.
pub fn pass(descriptor: &PipelineDescriptor) -> Option<String> {
    let (label, fragment) = match descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(d) => {
            (d.label.as_deref()?, d.fragment.as_ref()?)
        }
        PipelineDescriptor::ComputePipelineDescriptor(d) => {
            return Some(plugins_own(d.label.as_deref()?)?.into());
        }
        PipelineDescriptor::MeshPipelineDescriptor(_) => return None,
    };
    // Materials put their own name first.
    let name = match label.strip_prefix("pbr_").unwrap_or(label) {
        "prepass_pipeline" if has(fragment, "DEFERRED_PREPASS") => "deferred",
        // The cameras of the scenes with a prepass draw normals in it, shadow maps have none.
        "prepass_pipeline" if has(fragment, "NORMAL_PREPASS") => "prepass",
        "prepass_pipeline" => "shadow",
        "deferred_lighting_pipeline" => "deferred lighting",
        "tonemapping pipeline" => TONE_MAPPING,
        "blit pipeline" => COPY,
        _ if label.ends_with("_mesh_pipeline") => "forward",
        _ => plugins_own(label)?,
    };
    Some(name.into())
}

fn plugins_own(label: &str) -> Option<&str> {
    (label.starts_with("voxel_gi_") || label.starts_with("packed_ycocg_")).then_some(label)
}

fn has(fragment: &FragmentState, def: &'static str) -> bool {
    fragment.shader_defs.contains(&def.into())
}

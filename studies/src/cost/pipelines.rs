//! Every pipeline of an app, compiled between marks on a GPU that is not there, and what the driver printed, as rows.
//!
//! The driver prints the cost of a shader when it compiles it, without a name. An app compiles its
//! pipelines as it needs them, in any order; once it needs no more, those of interest are queued again
//! in Bevy's `PipelineCache`, one at a time, and the cache compiles each before the next is queued.
//! Shader modules are composed and validated only once, so the time is that of SPIR-V and the driver.

use std::{
    collections::BTreeMap,
    ffi::OsStr,
    path::{Path, PathBuf},
    process::{Command, Output},
    time::{Duration, Instant},
};

use bevy::render::{
    RenderApp,
    render_resource::{CachedPipelineState, FragmentState, PipelineCache, PipelineDescriptor},
};
use bevy_frugal_lab::{
    ROOT,
    headless::{HeadlessApp, HeadlessError},
};
use serde::{Deserialize, Serialize};

use crate::cost::{
    CostError,
    app::app,
    configurations::{Configuration, Scene},
    record::CostRow,
};
use crate::record::FileError;

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
pub fn compile(
    gpu: &str,
    program: &Command,
    configurations: &[Configuration],
) -> Result<Vec<CostRow>, CostError> {
    let parts = configurations.iter().map(Configuration::name);
    let mut rows = Vec::new();
    for output in run_parts(gpu, program, parts)? {
        rows.extend(rows_of(gpu, &String::from_utf8_lossy(&output?.stderr)));
    }
    Ok(rows)
}

/// Compiles the configuration that this process is to compile, and prints marks.
pub fn print(configurations: &[Configuration]) -> Result<(), CostError> {
    let part = part();
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
        let named = CostRow {
            plugin: configuration.plugin.into(),
            setting: configuration.setting.clone(),
            material: scene.material().into(),
            pass,
            ..CostRow::default()
        };
        Mark::Begin(named.into()).print();
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

/// Name of the environment variable with the part of the work that a process does.
pub const PART: &str = "COST_PART";

/// This program, to be started again.
pub fn this_program() -> Command {
    // Only Linux has the driver; there a program always finds itself.
    Command::new(std::env::current_exe().unwrap_or_default())
}

/// The version of Mesa that would be used, such as `Mesa 25.0.7`.
pub fn check() -> Result<String, CostError> {
    let output = output(script().arg("check"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.split(" in ").next().unwrap_or_default().into())
}

/// Runs a program on a GPU for each of the names, one after the other, with `PART` set to it, so that nothing of one
/// is left in the next. Returns what each wrote.
fn run_parts<'a>(
    gpu: &'a str,
    program: &'a Command,
    parts: impl IntoIterator<Item = String> + 'a,
) -> Result<impl Iterator<Item = Result<Output, CostError>> + 'a, CostError> {
    check()?;
    Ok(parts.into_iter().map(move |part| {
        let arguments = [OsStr::new("run"), OsStr::new(gpu), program.get_program()];
        let mut command = script();
        command
            .args(arguments)
            .args(program.get_args())
            .env(PART, &part);
        output(&mut command).map_err(|error| match error {
            CostError::NoDriver(text) => {
                let lines: Vec<_> = text.lines().collect();
                let end = &lines[lines.len().saturating_sub(12)..];
                CostError::Failed(format!("{part}\n{}", end.join("\n")))
            }
            error => error,
        })
    }))
}

/// The part that this process is to do, or empty.
pub fn part() -> String {
    std::env::var(PART).unwrap_or_default()
}

/// The script that runs a program on a GPU that is not there.
pub fn script() -> Command {
    Command::new(Path::new(ROOT).join("scripts/gpu-static"))
}

fn output(command: &mut Command) -> Result<Output, CostError> {
    let path = PathBuf::from(command.get_program());
    let output = command.output();
    let output = output.map_err(|source| FileError::new(&path, source))?;
    if output.status.success() {
        return Ok(output);
    }
    let text = String::from_utf8_lossy(&output.stderr);
    let text = text.trim_start_matches("error: ").trim_end();
    Err(CostError::NoDriver(text.into()))
}

/// What marks begin with.
const MARK: &str = "cost: ";

/// A line between the driver's, which says what it prints next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mark {
    /// The driver's name and version.
    Driver(String),
    /// A pipeline is compiled from here on; the row has the names of plugin, setting, material and pass.
    Begin(Box<CostRow>),
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
fn rows_of(gpu: &str, log: &str) -> Vec<CostRow> {
    let mut rows = Vec::new();
    let mut driver = String::new();
    let mut shaders = Vec::new();
    let mut named: Option<Box<CostRow>> = None;
    for line in log.lines() {
        if let Some(mark) = line.strip_prefix(MARK) {
            match serde_json::from_str(mark) {
                Ok(Mark::Driver(name)) => driver = name,
                Ok(Mark::End(ms)) => {
                    let found = shaders
                        .drain(..)
                        .filter_map(|s| row(named.as_ref()?, &s, ms));
                    rows.extend(found.map(|row| CostRow {
                        gpu: gpu.into(),
                        driver: driver.clone(),
                        ..row
                    }));
                    named = None;
                }
                Ok(Mark::Begin(row)) => {
                    shaders.clear();
                    named = Some(row);
                }
                Err(_) => named = None,
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

fn row(named: &CostRow, shader: &Shader, compile_ms: f64) -> Option<CostRow> {
    if shader.stage != "pixel" && shader.stage != "compute" {
        return None;
    }
    let figure = |key: &str| shader.figures.get(key).copied();
    Some(CostRow {
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
        ..named.clone()
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
        let named = CostRow {
            plugin: "ewa".into(),
            setting: "linear".into(),
            material: "base colour".into(),
            pass: "forward".into(),
            ..CostRow::default()
        };
        let begin = Mark::Begin(named.into());
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
        let found = rows_of("navi31", &log.concat());
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

//! The time until all pipelines of a scene are compiled, from the start of the app, on a GPU that is not there.
//!
//! Every material has other maps, as in a scene of a game, so that pipelines differ. Bevy alone and the plugin run in
//! processes of their own, one after the other and in several rounds; the shortest time of each counts, since other
//! programs only add to it.

use std::{collections::BTreeMap, path::Path, time::Instant};

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        render_resource::{PipelineCache, TextureFormat},
    },
};
use serde::{Deserialize, Serialize};

use super::{
    app::{add_plugin, spawn_camera, spawn_light},
    configurations::{Kind, configurations},
    error::CostError,
    pipelines::settle,
    record::write_json,
    scene::Scene,
    shim,
    skin::{SMALL_TEXTURE, texture},
};
use crate::headless::{HeadlessApp, HeadlessSettings};

/// Name of the file in its folder.
pub const FILE: &str = "compile_times.json";

const ROUNDS: usize = 3;
/// Numbers of materials.
const COUNTS: [usize; 2] = [1, 10];
/// The settings, as plugin and setting: Bevy alone comes first.
const SETTINGS: [(&str, &str); 4] = [
    ("bevy", "default"),
    ("ewa", "linear"),
    ("ewa", "approximate, 16x sampler"),
    ("ewa", "trilinear"),
];

/// The time of one setting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CompileTime {
    /// Name of the plugin.
    pub plugin: String,
    /// Name of its setting.
    pub setting: String,
    /// Number of materials.
    pub materials: usize,
    /// Number of pipelines.
    pub pipelines: usize,
    /// Shortest time from the start of the app in seconds.
    pub seconds: f64,
    /// Bevy's own.
    pub baseline_seconds: f64,
}

/// Writes [`FILE`] into a folder; or, under the driver, measures one process's part.
///
/// # Errors
/// [`CostError`].
pub fn measure(inside: bool, gpu: &str, folder: &Path) -> Result<(), CostError> {
    if inside {
        println!("{}", serde_json::json!(measured(&shim::part())?));
        return Ok(());
    }
    let parts = { COUNTS.into_iter() }
        .flat_map(|count| SETTINGS.map(|(plugin, setting)| format!("{count} {plugin}: {setting}")));
    let parts: Vec<_> = parts.collect();
    let parts: Vec<_> = (0..ROUNDS).flat_map(|_| parts.clone()).collect();
    let mut program = shim::this_program();
    program.args(["cost", "--compile-times", "--inside"]);
    let mut rows: BTreeMap<String, CompileTime> = BTreeMap::new();
    for (part, output) in parts
        .iter()
        .zip(shim::run(gpu, &program, parts.iter().cloned())?)
    {
        let output = output?.stdout;
        let mut lines = output.split(|byte| *byte == b'\n');
        let row: CompileTime = lines
            .find_map(|line| serde_json::from_slice(line).ok())
            .ok_or_else(|| CostError::Failed(format!("{part}: no time")))?;
        println!("{part}: {:.2} s, {} pipelines", row.seconds, row.pipelines);
        let best = rows.entry(part.clone()).or_insert_with(|| row.clone());
        best.seconds = best.seconds.min(row.seconds);
    }
    let rows: Vec<_> = rows.into_values().collect();
    let rows = rows.iter().map(|row| {
        let bevys = rows
            .iter()
            .find(|bevy| bevy.plugin == "bevy" && bevy.materials == row.materials);
        CompileTime {
            baseline_seconds: bevys.map_or(0.0, |bevy| bevy.seconds),
            ..row.clone()
        }
    });
    write_json(&rows.collect::<Vec<_>>(), &folder.join(FILE))
}

fn measured(part: &str) -> Result<CompileTime, CostError> {
    let unknown = || CostError::Failed(format!("{part}: no such setting"));
    let (count, name) = part.split_once(' ').ok_or_else(unknown)?;
    let count = count.parse().map_err(|_| unknown())?;
    let mut all = configurations().into_iter();
    let configuration = all.find(|c| c.name() == name).ok_or_else(unknown)?;
    let start = Instant::now();
    let mut app = room(&configuration.kind, count)?;
    settle(&mut app)?;
    let seconds = start.elapsed().as_secs_f64();
    let render_app = app.app_mut().sub_app(RenderApp);
    let pipelines = render_app.world().resource::<PipelineCache>().pipelines();
    Ok(CompileTime {
        plugin: configuration.plugin.into(),
        setting: configuration.setting,
        materials: count,
        pipelines: pipelines.count(),
        seconds: (seconds * 100.0).round() / 100.0,
        baseline_seconds: 0.0,
    })
}

/// A quad for each of so many materials, in front of one camera, with a point light that has shadows.
fn room(kind: &Kind, materials: usize) -> Result<HeadlessApp, CostError> {
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(64, 64), |app| {
        add_plugin(app, kind);
    })?;
    let world = app.world_mut();
    spawn_camera(world, kind, Scene::BaseColor);
    spawn_light(world, Vec3::new(1.0, 1.0, 2.0));
    let mesh = Mesh::from(Rectangle::default()).with_generated_tangents();
    let mesh = mesh.map_err(|error| CostError::Failed(error.to_string()))?;
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    for i in 0..materials {
        let mut images = world.resource_mut::<Assets<Image>>();
        let material = material(i, &mut images);
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let material = materials.add(material);
        let place = Transform::from_xyz(0.1 * i as f32 - 0.5, 0.0, 0.0);
        world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material), place));
    }
    Ok(app)
}

/// The maps of materials in a scene of a game, as letters: colour, normals, roughness, occlusion, emissive, and `m` for
/// an alpha mask.
const MATERIALS: [&str; 10] = [
    "c", "cn", "cnroe", "cnr", "cm", "cnro", "ce", "cnm", "", "cr",
];

fn material(index: usize, images: &mut Assets<Image>) -> StandardMaterial {
    let letters = MATERIALS[index % MATERIALS.len()];
    let has = |letter| letters.contains(letter);
    let (color, data) = (TextureFormat::Rgba8UnormSrgb, TextureFormat::Rgba8Unorm);
    let mut map = |letter, format| has(letter).then(|| images.add(texture(SMALL_TEXTURE, format)));
    StandardMaterial {
        base_color_texture: map('c', color),
        normal_map_texture: map('n', data),
        metallic_roughness_texture: map('r', data),
        occlusion_texture: map('o', data),
        emissive_texture: map('e', color),
        emissive: LinearRgba::WHITE,
        alpha_mode: if has('m') {
            AlphaMode::Mask(0.5)
        } else {
            AlphaMode::Opaque
        },
        ..default()
    }
}

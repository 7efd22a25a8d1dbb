//! The CPU's time for a frame with many meshes, where the GPU takes none: what is in it is Bevy and the
//! plugin. Frames of Bevy alone and with the plugin are interleaved in one process; figures are medians.

use std::{path::Path, time::Instant};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    app::{Skin, add_plugin, spawn_camera},
    configurations::{Kind, PLUGINS, configurations},
    error::CostError,
    pipelines::settle,
    record,
    scene::Scene,
    shim,
};
use crate::headless::{HeadlessApp, HeadlessSettings, median};

const MESHES: [usize; 3] = [1_000, 10_000, 100_000];
const MATERIALS: [usize; 2] = [1, 100];
/// One of this many meshes moves, where some do.
const MOVING: usize = 100;
const ROUNDS: usize = 5;
/// Frames of an app in a round.
const FRAMES: usize = 6;
/// Frames after which a volume of light has settled where nothing moves.
const FIRST_FRAMES: usize = 40;
/// Edge of the field of meshes in metres.
const FIELD: f32 = 40.0;

/// The CPU's time with a plugin at its defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CpuRow {
    /// Name of the plugin.
    pub plugin: String,
    /// Number of meshes in view.
    pub meshes: usize,
    /// Number of materials among them.
    pub materials: usize,
    /// Number of meshes that move in every frame.
    pub moving: usize,
    /// Time of a frame in milliseconds, less Bevy's own.
    pub frame_ms: f64,
    /// Time of a frame of Bevy alone in milliseconds.
    pub baseline_ms: f64,
}

impl CpuRow {
    fn name(&self) -> String {
        let Self {
            plugin,
            meshes,
            materials,
            moving,
            ..
        } = self;
        format!("{plugin}: {meshes} meshes, {moving} moving, {materials} materials")
    }
}

/// Writes `cpu.json` into a folder; or, under the driver, measures one row.
///
/// # Errors
/// [`CostError`].
pub fn measure(inside: bool, gpu: &str, folder: &Path) -> Result<(), CostError> {
    let rows = rows();
    if inside {
        let part = shim::part();
        for row in rows.into_iter().filter(|row| row.name() == part) {
            println!("{}", serde_json::json!(measured(row)?));
        }
        return Ok(());
    }
    let mut program = shim::this_program();
    program.args(["cost", "--cpu", "--inside"]);
    let mut found: Vec<CpuRow> = Vec::new();
    for output in shim::run(gpu, &program, rows.iter().map(CpuRow::name))? {
        let output = output?.stdout;
        let lines = output.split(|byte| *byte == b'\n');
        found.extend(lines.filter_map(|line| serde_json::from_slice::<CpuRow>(line).ok()));
        if let Some(row) = found.last() {
            println!(
                "{}: {:+.2} ms beside {:.2} ms",
                row.name(),
                row.frame_ms,
                row.baseline_ms
            );
        }
    }
    record::write_json(&found, &folder.join("cpu.json"))
}

fn rows() -> Vec<CpuRow> {
    let mut rows = Vec::new();
    for (plugin, _) in PLUGINS {
        for meshes in MESHES {
            for materials in MATERIALS {
                for moving in [0, meshes / MOVING] {
                    let plugin = plugin.to_string();
                    rows.push(CpuRow {
                        plugin,
                        meshes,
                        materials,
                        moving,
                        frame_ms: 0.0,
                        baseline_ms: 0.0,
                    });
                }
            }
        }
    }
    rows
}

fn measured(row: CpuRow) -> Result<CpuRow, CostError> {
    let all = configurations();
    let is_default = |setting: &str| PLUGINS.contains(&(&*row.plugin, setting));
    let plugin = all
        .iter()
        .find(|c| c.plugin == row.plugin && is_default(&c.setting));
    let kinds = [Some(&Kind::Bevy), plugin.map(|c| &c.kind)];
    let mut apps = Vec::new();
    for kind in kinds.into_iter().flatten() {
        let mut app = field(&row, kind)?;
        settle(&mut app)?;
        (0..FIRST_FRAMES).for_each(|_| app.app_mut().update());
        apps.push((app, Vec::new()));
    }
    for _ in 0..ROUNDS {
        for (app, times) in &mut apps {
            for _ in 0..FRAMES {
                let start = Instant::now();
                app.app_mut().update();
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    let medians: Vec<_> = apps
        .into_iter()
        .map(|(_, times)| median(&times).unwrap_or_default())
        .collect();
    let baseline_ms = medians[0];
    Ok(CpuRow {
        frame_ms: medians.last().map_or(0.0, |ms| ms - baseline_ms),
        baseline_ms,
        ..row
    })
}

#[derive(Component)]
struct Moving;

/// All meshes in view, in a square on the floor.
fn field(row: &CpuRow, kind: &Kind) -> Result<HeadlessApp, CostError> {
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(64, 64), |app| {
        add_plugin(app, kind);
        app.add_systems(Update, shake);
    })?;
    let world = app.world_mut();
    spawn_camera(world, kind, Scene::BaseColor);
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut camera in cameras.iter_mut(world) {
        *camera = Transform::from_xyz(0.0, FIELD, FIELD).looking_at(Vec3::ZERO, Vec3::Y);
    }
    world.spawn((PointLight::default(), Transform::from_xyz(0.0, 4.0, 0.0)));
    let side = (row.meshes as f32).sqrt().ceil() as usize;
    let step = FIELD / side as f32;
    let mesh = Mesh::from(Cuboid::from_length(0.5 * step));
    let mesh = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(mesh));
    let skins: Vec<_> = (0..row.materials)
        .map(|_| Skin::new(world, kind, Scene::BaseColor))
        .collect();
    for i in 0..row.meshes {
        let at = Vec3::new((i % side) as f32, 0.0, (i / side) as f32) * step;
        let place = Transform::from_translation(at - Vec3::new(0.5, 0.0, 0.5) * FIELD);
        let mut entity = world.spawn((mesh.clone(), place));
        if row.moving > 0 && i % MOVING == 0 {
            entity.insert(Moving);
        }
        skins[i % skins.len()].put_on(entity);
    }
    if let Kind::Gi(volume) = kind {
        let mut volume = volume.clone();
        volume.size = FIELD;
        world.spawn(volume);
    }
    Ok(app)
}

fn shake(time: Res<Time>, mut moving: Query<&mut Transform, With<Moving>>) {
    for mut place in &mut moving {
        place.translation.y = time.elapsed_secs().sin();
    }
}

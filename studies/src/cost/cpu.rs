//! The CPU's time for the plugins' systems in a frame with many meshes, all of them in view, where the GPU takes none.
//! In a crowd some of them are characters with a skin that moves.
//!
//! Linux's `perf` samples where the processors are, so that what other programs do hardly matters. Bevy is compiled
//! without its spans here; the names are those of the functions in the program.

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Command, Stdio},
};

use bevy::{
    mesh::{
        VertexAttributeValues,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessSettings};
use serde::{Deserialize, Serialize};

use crate::{
    cost::{
        CostError,
        app::{SMALL_TEXTURE, Skin, add_plugin, spawn_camera},
        configurations::{Kind, PLUGINS, Scene, configurations},
        pipelines::{PART, part, script, settle, this_program},
    },
    page::{self, number},
    record::write_json,
};

/// Name of the file in its folder.
pub const FILE: &str = "cpu_systems.json";
/// Samples a second of each processor.
const RATE: u32 = 1999;
/// Systems that take less are not listed.
const LEAST_MS: f64 = 0.1;
/// What the lines begin with that say when measuring begins and ends.
const MARK: &str = "measuring: ";
/// What symbols have in them whose names are mangled with all their types, so that they name the systems that are inlined
/// into them.
const NAMED: &str = "FunctionSystem<fn(";
/// Frames that are measured, and where nothing moves.
const FRAMES: usize = 120;
const STILL_FRAMES: usize = 240;
/// Frames after which a volume of light has settled where nothing moves.
const FIRST_FRAMES: usize = 60;

/// Meshes of 12 triangles, and how many of them move in every frame or are despawned in every frame, with as many
/// spawned in their place; and characters beside them.
const FIELDS: [Field; 6] = [
    Field::new(30_000, 0, 0, 0),
    Field::new(10_000, 0, 100, 0),
    Field::new(10_000, 100, 0, 0),
    Field::new(100_000, 0, 0, 0),
    Field::new(100_000, 1_000, 0, 0),
    Field::new(42_000, 1_000, 0, 200),
];
/// Joints of a character.
const JOINTS: usize = 60;
/// Edge of the field in metres.
const EDGE: f32 = 40.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Field {
    pub meshes: usize,
    pub moving: usize,
    pub replaced: usize,
    pub characters: usize,
}

impl Field {
    const fn new(meshes: usize, moving: usize, replaced: usize, characters: usize) -> Self {
        Self {
            meshes,
            moving,
            replaced,
            characters,
        }
    }

    fn is_still(self) -> bool {
        self.moving + self.replaced + self.characters == 0
    }

    fn frames(self) -> usize {
        if self.is_still() {
            STILL_FRAMES
        } else {
            FRAMES
        }
    }
}

/// The time of a system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SystemRow {
    /// Name of the plugin.
    pub plugin: String,
    #[serde(flatten)]
    pub field: Field,
    /// Path of the function, or the name of the crate for all of its systems.
    pub system: String,
    /// Its time on processors in a frame in milliseconds, with all that it calls on its thread.
    pub process_ms: f64,
}

/// Writes the systems of each plugin into a folder, and what all of a plugin's systems take together, by the name of
/// its crate; or, under the driver, draws the frames of one process.
pub fn measure(inside: bool, gpu: &str, folder: &Path) -> Result<(), CostError> {
    if inside {
        return draw(&part());
    }
    let mut rows = Vec::new();
    for (index, field) in FIELDS.into_iter().enumerate() {
        for (plugin, _) in PLUGINS {
            for (system, process_ms) in sampled(gpu, plugin, &format!("{plugin} {index}"))? {
                println!("{plugin}, {field:?}: {process_ms:.2} ms {system}");
                rows.push(SystemRow {
                    plugin: plugin.into(),
                    field,
                    system,
                    process_ms,
                });
            }
        }
    }
    Ok(write_json(&rows, &folder.join(FILE))?)
}

/// Draws the frames of a part of the work: the name of a plugin, which is at its defaults, and the index of a field.
fn draw(part: &str) -> Result<(), CostError> {
    let words = part.split_once(' ');
    let field = words.and_then(|(_, index)| FIELDS.get(index.parse::<usize>().ok()?));
    let kind = words.and_then(|(plugin, _)| {
        let mut all = configurations().into_iter();
        all.find(|c| c.plugin == plugin && PLUGINS.contains(&(plugin, &c.setting)))
    });
    let (Some(field), Some(configuration)) = (field, kind) else {
        return Err(CostError::Failed(format!("no such part: `{part}`")));
    };
    let mut app = app(*field, &configuration.kind)?;
    settle(&mut app)?;
    if field.is_still() {
        (0..FIRST_FRAMES).for_each(|_| app.app_mut().update());
    }
    println!("{MARK}0 {}", seconds_since_boot());
    (0..field.frames()).for_each(|_| app.app_mut().update());
    println!("{MARK}{} {}", field.frames(), seconds_since_boot());
    Ok(())
}

#[derive(Component)]
struct Moving;

#[derive(Component, Clone)]
struct Replaced;

/// The app, before its first frame.
fn app(field: Field, kind: &Kind) -> Result<HeadlessApp, CostError> {
    let mut app = HeadlessApp::new(HeadlessSettings::with_size(64, 64), |app| {
        add_plugin(app, kind);
        app.add_systems(Update, (shake, replace));
    })?;
    let world = app.world_mut();
    spawn_camera(world, kind, Scene::BaseColor);
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut camera in cameras.iter_mut(world) {
        *camera = Transform::from_xyz(0.0, EDGE, EDGE).looking_at(Vec3::ZERO, Vec3::Y);
    }
    world.spawn((PointLight::default(), Transform::from_xyz(0.0, 4.0, 0.0)));
    let side = (field.meshes as f32).sqrt().ceil() as usize;
    let step = EDGE / side as f32;
    let mesh = Mesh::from(Cuboid::from_length(0.5 * step));
    let mesh = Mesh3d(world.add_asset(mesh));
    let skin = Skin::new(world, kind, Scene::BaseColor, SMALL_TEXTURE);
    for i in 0..field.meshes {
        let at = Vec3::new((i % side) as f32, 0.0, (i / side) as f32) * step;
        let place = Transform::from_translation(at - Vec3::new(0.5, 0.0, 0.5) * EDGE);
        let mut entity = world.spawn((mesh.clone(), place));
        let is_one_of = |count: usize| count > 0 && i % (field.meshes / count) == 0;
        if is_one_of(field.moving) {
            entity.insert(Moving);
        }
        if is_one_of(field.replaced) {
            entity.insert(Replaced);
        }
        skin.put_on(entity);
    }
    spawn_characters(world, field.characters, &skin);
    if let Kind::Gi(settings, volume) = kind {
        let mut volume = volume.clone();
        volume.size = EDGE;
        world.insert_resource(settings.clone());
        world.spawn(volume);
    }
    Ok(app)
}

/// Characters spread over the field, each with a skin whose joints all move.
fn spawn_characters(world: &mut World, count: usize, skin: &Skin) {
    if count == 0 {
        return;
    }
    let mut mesh = Mesh::from(Capsule3d::new(0.3, 1.2));
    let joint_of = |vertex: usize| [(vertex % JOINTS) as u16, 0, 0, 0];
    let vertices = mesh.count_vertices();
    let joints = (0..vertices).map(joint_of).collect();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(joints),
    );
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_WEIGHT,
        vec![[1.0, 0.0, 0.0, 0.0]; vertices],
    );
    let mesh = Mesh3d(world.add_asset(mesh));
    let poses = vec![Mat4::IDENTITY; JOINTS];
    let inverse_bindposes = world.add_asset(SkinnedMeshInverseBindposes::from(poses));
    let side = (count as f32).sqrt().ceil() as usize;
    for i in 0..count {
        let cell = Vec3::new((i % side) as f32, 0.0, (i / side) as f32) + Vec3::new(0.5, 0.0, 0.5);
        let place = cell * (EDGE / side as f32) - Vec3::new(0.5, 0.0, 0.5) * EDGE;
        let spawn_joint = |_| {
            let place = Transform::from_translation(place);
            world.spawn((Moving, place)).id()
        };
        let joints = (0..JOINTS).map(spawn_joint).collect();
        let inverse_bindposes = inverse_bindposes.clone();
        let skinned = SkinnedMesh {
            inverse_bindposes,
            joints,
        };
        skin.put_on(world.spawn((mesh.clone(), Transform::default(), skinned)));
    }
}

fn shake(time: Res<Time>, mut moving: Query<&mut Transform, With<Moving>>) {
    for mut place in &mut moving {
        place.translation.y = time.elapsed_secs().sin();
    }
}

fn replace(mut commands: Commands, replaced: Query<Entity, With<Replaced>>) {
    for entity in &replaced {
        commands.entity(entity).clone_and_spawn();
        commands.entity(entity).despawn();
    }
}

/// On `perf`'s clock, in hundredths.
fn seconds_since_boot() -> String {
    let text = fs::read_to_string("/proc/uptime").unwrap_or_default();
    text.split(' ').next().unwrap_or_default().into()
}

fn sampled(gpu: &str, plugin: &str, name: &str) -> Result<Vec<(String, f64)>, CostError> {
    let failed = |text: &str| CostError::Failed(format!("{name}: {text}"));
    let file = std::env::temp_dir().join(format!("cost-{}.perf", std::process::id()));
    let rate = RATE.to_string();
    let mut perf = Command::new("perf");
    perf.args([
        "record",
        "-q",
        "-k",
        "CLOCK_BOOTTIME",
        "-e",
        "cpu-clock",
        "-F",
        &rate,
        "--call-graph",
        "dwarf,16384",
        "-o",
    ]);
    perf.arg(&file).arg("--").arg(script().get_program());
    perf.args(["run", gpu]).arg(this_program().get_program());
    perf.args(["cost", "--systems", "--inside"]).env(PART, name);
    let output = perf.stderr(Stdio::null()).output();
    let output = output.map_err(|error| failed(&format!("`perf` is needed for this: {error}")))?;
    let marks = marks(&String::from_utf8_lossy(&output.stdout));
    let script = Command::new("perf")
        .args(["script", "--no-inline", "-F", "time,ip,sym", "-i"])
        .arg(&file)
        .output();
    let _ = fs::remove_file(&file);
    let script = script.map_err(|error| failed(&error.to_string()))?;
    let (frames, window) = marks.ok_or_else(|| failed("no frames"))?;
    let script = String::from_utf8_lossy(&script.stdout);
    if !script.contains(NAMED) {
        return Err(failed(
            "the program's symbols do not name its systems; docs/measuring.md says how to compile it",
        ));
    }
    let counts = counts(&script, window, plugin);
    let sample_ms = 1e3 / f64::from(RATE) / frames;
    let ms = |count: u32| (f64::from(count) * sample_ms * 100.0).round() / 100.0;
    let all = (format!("bevy_{plugin}"), ms(counts.values().sum()));
    let systems = counts
        .into_iter()
        .map(|(system, count)| (system, ms(count)));
    let mut systems: Vec<_> = systems.filter(|(_, ms)| *ms >= LEAST_MS).collect();
    systems.push(all);
    systems.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(systems)
}

/// Samples in a window of time by the plugin's system. A sample is a line with its time, and then a line for each
/// function, the innermost first: the system is the outermost one of the plugin.
fn counts(script: &str, window: [f64; 2], plugin: &str) -> BTreeMap<String, u32> {
    let crate_path = format!("bevy_{plugin}::");
    let mut counts = BTreeMap::new();
    for sample in script.split("\n\n") {
        let mut lines = sample.trim().lines();
        let time = lines
            .next()
            .and_then(|line| line.trim().strip_suffix(':')?.parse().ok());
        let is_measured = time.is_some_and(|time: f64| window[0] <= time && time <= window[1]);
        let system = lines.rev().find_map(|line| system(line, &crate_path));
        if let Some(system) = system.filter(|_| is_measured) {
            *counts.entry(system.to_owned()).or_default() += 1;
        }
    }
    counts
}

/// How many frames were measured, from when to when.
fn marks(output: &str) -> Option<(f64, [f64; 2])> {
    let marks = output
        .lines()
        .filter_map(|line| line.strip_prefix(MARK)?.split_once(' '));
    let marks: Vec<[f64; 2]> = marks
        .filter_map(|(frames, time)| Some([frames.parse().ok()?, time.parse().ok()?]))
        .collect();
    match marks[..] {
        [[_, start], [frames, end]] => Some((frames, [start, end])),
        _ => None,
    }
}

/// The last path of the crate in a symbol. The function is the last parameter of what Bevy makes of a system, and of
/// what a system calls with a closure.
fn system<'a>(symbol: &'a str, crate_path: &str) -> Option<&'a str> {
    let path = &symbol[symbol.rfind(crate_path)?..];
    let end = path.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    Some(path[..end.unwrap_or(path.len())].trim_end_matches(':'))
}

/// The plugins' systems by name, and all of a plugin together, with their times by field of meshes.
pub fn table(rows: &[SystemRow]) -> String {
    let mut fields: Vec<_> = rows.iter().map(|row| row.field).collect();
    fields.sort_unstable();
    fields.dedup();
    let heads = fields.iter().map(|field| {
        let change = match (field.moving, field.replaced, field.characters) {
            (0, 0, 0) => "nothing changes".to_string(),
            (moving, 0, 0) => format!("{moving} move"),
            (moving, 0, characters) => format!("{moving} and {characters} characters move"),
            (_, replaced, _) => format!("{replaced} are replaced"),
        };
        format!("{}: {change}", field.meshes)
    });
    let heads: Vec<_> = ["system, ms".to_string()]
        .into_iter()
        .chain(heads)
        .collect();
    let mut names: Vec<_> = rows.iter().map(|row| &row.system).collect();
    names.sort_unstable();
    names.dedup();
    let lines = names.into_iter().map(|name| {
        let cells = fields.iter().map(|field| {
            let row = { rows.iter() }.find(|row| row.system == *name && row.field == *field);
            number(row.map(|row| row.process_ms), 2)
        });
        [format!("`{name}`")].into_iter().chain(cells).collect()
    });
    page::table(&heads, lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_the_last_path_of_its_symbol() {
        let symbol = "<bevy_ecs::system::FunctionSystem<fn(Res<bevy_voxel_gi::report::Report>), (), (), \
                      bevy_voxel_gi::extract::meshes::extract_scene> as System>::run_unsafe";
        let name = "bevy_voxel_gi::extract::meshes::extract_scene";
        assert_eq!(system(symbol, "bevy_voxel_gi::"), Some(name));
        assert_eq!(
            system(&format!("{name}::{{closure#0}}"), "bevy_voxel_gi::"),
            Some(name)
        );
        assert_eq!(system(symbol, "bevy_ewa::"), None);
    }

    #[test]
    fn samples_count_for_the_outermost_function_within_the_window() {
        let sample = |time: f64| {
            format!(
                "{time}: \n\t 1 malloc\n\t 2 bevy_ewa::mips::level\n\t 3 bevy_ewa::mips::start\n\t 4 main\n\n"
            )
        };
        let script = [1.0, 2.0, 2.5, 4.0].map(sample).concat();
        let found = counts(&script, [1.5, 3.0], "ewa");
        assert_eq!(found, [("bevy_ewa::mips::start".to_string(), 2)].into());
        assert!(counts(&script, [1.5, 3.0], "voxel_gi").is_empty());
    }

    #[test]
    fn marks_are_read_back() {
        let output = format!("{MARK}0 1.5\n{{}}\n{MARK}30 2.25\n");
        assert_eq!(marks(&output), Some((30.0, [1.5, 2.25])));
        assert_eq!(marks("{}"), None);
    }
}

//! Scenes of meshes with textures, in which something moves.
//!
//! Their truth is traced when the study runs; that of the arcade's test is committed. Each volume is compared once the light has settled in the usual state;
//! then something changes, and the picture is compared with the truth of the new state some frames after the change and
//! once the light has settled again.

use std::collections::BTreeMap;

use bevy::prelude::*;
use bevy_frugal_lab::{
    boxes::{agreement, block_means},
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat},
    meshes::{MeshScene, SpawnedScene, move_to, spawn_mesh_scene, trace},
    path_tracer::TraceSettings,
};
use bevy_voxel_gi::{Follow, Sky, VoxelGiPlugin, VoxelGiReport, VoxelGiSettings, VoxelGiVolume};

use crate::{
    page::table,
    voxel_gi::{
        LightRow,
        render::{MAX_FRAMES, difference, halved, picture, settle},
    },
};

/// Frames after a change at which a picture is compared.
pub const FRAMES: [u32; 3] = [1, 8, 30];

/// A scene from one camera: the usual state, and others that each follow it; with names.
pub struct View {
    pub usual: (&'static str, MeshScene),
    pub changes: Vec<(&'static str, MeshScene)>,
}

/// Views of a scene in Bevy, and their truth.
pub struct MeshApp {
    pub app: HeadlessApp,
    spawned: SpawnedScene,
    views: Vec<(StateTruth, Vec<StateTruth>)>,
}

/// A state from a camera.
struct StateTruth {
    name: &'static str,
    scene: MeshScene,
    /// The picture without a volume.
    without: Vec<Vec3>,
    /// Block means of the path-traced light that a volume is to add.
    truth: Vec<Vec3>,
}

/// Block means of the path-traced light of states that a volume is to add, by their names.
pub type Truth = BTreeMap<String, Vec<[f32; 3]>>;

/// Traces the truth of views with this number of samples.
pub fn traced(views: &[View], samples: u32) -> Truth {
    let settings = TraceSettings {
        samples,
        ..default()
    };
    let states = views
        .iter()
        .flat_map(|view| std::iter::once(&view.usual).chain(&view.changes));
    let truth = states.map(|(name, scene)| {
        let traced = trace(scene, &settings);
        let means = block_means(&traced.indirect, traced.width);
        (name.to_string(), means.iter().map(Vec3::to_array).collect())
    });
    truth.collect()
}

impl MeshApp {
    /// Renders views of the same parts without a volume.
    pub fn new(views: Vec<View>, truth: &Truth) -> Result<Self, HeadlessError> {
        let first = &views[0].usual.1;
        let camera = &first.stage.camera;
        // Twice as wide as the truth, since a pixel of Bevy's has one sample of the geometry.
        let mut app = HeadlessApp::new(
            HeadlessSettings {
                format: TargetFormat::Float32,
                ..HeadlessSettings::with_size(2 * camera.width, 2 * camera.height)
            },
            |app| {
                app.add_plugins(VoxelGiPlugin);
            },
        )?;
        let world = app.world_mut();
        let spawned = spawn_mesh_scene(world, first);
        // What a volume adds does not depend on shadow maps, which take most of the time of a software driver.
        for mut light in world.query::<&mut PointLight>().iter_mut(world) {
            light.shadow_maps_enabled = false;
        }
        for mut light in world.query::<&mut DirectionalLight>().iter_mut(world) {
            light.shadow_maps_enabled = false;
        }
        app.run_until_ready(MAX_FRAMES)?;
        let mut with_truth = |(name, scene): (&'static str, MeshScene)| {
            move_to(app.world_mut(), &spawned, &scene);
            app.render_frames(2)?;
            Ok(StateTruth {
                name,
                without: picture(&mut app)?,
                truth: truth[name].iter().copied().map(Vec3::from).collect(),
                scene,
            })
        };
        let mut rendered = Vec::new();
        for View { usual, changes } in views {
            let usual = with_truth(usual)?;
            let changes = changes.into_iter().map(&mut with_truth);
            rendered.push((usual, changes.collect::<Result<_, HeadlessError>>()?));
        }
        Ok(Self {
            app,
            spawned,
            views: rendered,
        })
    }

    /// The errors of a volume in each state; `place` gives it for a scene.
    pub fn rows(
        &mut self,
        name: &str,
        settings: &VoxelGiSettings,
        place: impl Fn(&MeshScene) -> (VoxelGiVolume, Transform),
    ) -> Result<Vec<LightRow>, HeadlessError> {
        let (app, spawned) = (&mut self.app, &self.spawned);
        app.world_mut().insert_resource(settings.clone());
        let mut rows = Vec::new();
        for (usual, changes) in &self.views {
            let scene = &usual.scene;
            move_to(app.world_mut(), spawned, scene);
            let (volume, pose) = place(scene);
            let sky = Some(Sky::uniform(LinearRgba::from_vec3(
                scene.stage.sky_radiance,
            )));
            let volume = app
                .world_mut()
                .spawn((VoxelGiVolume { sky, ..volume }, pose));
            let volume = volume.id();
            settle(app)?;
            rows.push(usual.row(app, name.into())?);
            for (index, state) in changes.iter().enumerate() {
                if index > 0 {
                    // Every change begins with the usual state.
                    move_to(app.world_mut(), spawned, scene);
                    settle(app)?;
                }
                move_to(app.world_mut(), spawned, &state.scene);
                let mut rendered = 0;
                for frame in FRAMES {
                    app.render_frames(frame - rendered)?;
                    rendered = frame;
                    rows.push(state.row(app, format!("{name}, frame {frame}"))?);
                }
                settle(app)?;
                rows.push(state.row(app, name.into())?);
            }
            app.world_mut().despawn(volume);
            // The frame in which a volume ends may still show it.
            app.render_frames(2)?;
        }
        Ok(rows)
    }
}

/// Frames of a flight, and metres in each: 3 m/s at 60 frames a second.
const FLIGHT: u32 = 90;
const FLIGHT_STEP: f32 = 0.05;

impl MeshApp {
    /// How the light of resting surfaces changes from frame to frame while the default volume flies along the camera's view.
    pub fn flight_rows(
        &mut self,
        name: &str,
        settings: &VoxelGiSettings,
    ) -> Result<Vec<LightRow>, HeadlessError> {
        let (app, spawned) = (&mut self.app, &self.spawned);
        app.world_mut().insert_resource(settings.clone());
        let mut rows = Vec::new();
        for (usual, _) in &self.views {
            move_to(app.world_mut(), spawned, &usual.scene);
            let stage = &usual.scene.stage;
            let sky = Some(Sky::uniform(LinearRgba::from_vec3(stage.sky_radiance)));
            let pose = Transform::from_translation(stage.camera.eye)
                .looking_at(stage.camera.target, Vec3::Y);
            let leader = app.world_mut().spawn(pose).id();
            let volume = VoxelGiVolume {
                sky,
                follow: Follow::Entity(leader),
                ..default()
            };
            let volume = app.world_mut().spawn(volume).id();
            settle(app)?;
            let width = stage.camera.width;
            let mut previous = block_means(&usual.added(app)?, width);
            let mut changes = Vec::new();
            for _ in 0..FLIGHT {
                if let Some(mut leader) = app.world_mut().get_mut::<Transform>(leader) {
                    let forward = leader.forward();
                    leader.translation += forward * FLIGHT_STEP;
                }
                app.render_frames(1)?;
                let now = block_means(&usual.added(app)?, width);
                changes.extend(relative_changes(&previous, &now));
                previous = now;
            }
            let squares = changes.iter().map(|change| change * change);
            rows.push(LightRow {
                scene: usual.name.into(),
                setting: format!("{name}, flight"),
                flicker: Some((squares.sum::<f64>() / changes.len() as f64).sqrt()),
                greatest_change: changes.iter().copied().reduce(f64::max),
                ..LightRow::default()
            });
            for entity in [volume, leader] {
                app.world_mut().despawn(entity);
            }
            app.render_frames(2)?;
        }
        Ok(rows)
    }
}

/// By how much blocks change, as a share of their light: those with less than a tenth of the mean, of that.
fn relative_changes(before: &[Vec3], after: &[Vec3]) -> Vec<f64> {
    let of = |block: &Vec3| f64::from(block.element_sum());
    let mean = before.iter().map(of).sum::<f64>() / before.len().max(1) as f64;
    let pairs = before.iter().zip(after);
    // A block in which one pixel has no light is none.
    pairs
        .filter(|(a, b)| **a != Vec3::ZERO && **b != Vec3::ZERO)
        .map(|(a, b)| (of(b) - of(a)).abs() / of(a).max(0.1 * mean))
        .collect()
}

impl StateTruth {
    /// The light that the volume adds now, in the size of the truth.
    fn added(&self, app: &mut HeadlessApp) -> Result<Vec<Vec3>, HeadlessError> {
        let added = difference(&picture(app)?, &self.without);
        Ok(halved(&added, 2 * self.scene.stage.camera.width))
    }

    fn row(&self, app: &mut HeadlessApp, setting: String) -> Result<LightRow, HeadlessError> {
        let width = self.scene.stage.camera.width;
        let found = agreement(&self.added(app)?, width, &self.truth);
        Ok(LightRow {
            scene: self.name.into(),
            setting,
            bytes: Some(app.world().resource::<VoxelGiReport>().memory),
            relative_error: Some(found.relative_error),
            bias: Some(found.bias),
            percentile_95: Some(found.percentile_95),
            black: Some(found.black),
            ..LightRow::default()
        })
    }
}

/// The rows of a scene and a setting that are in a cell; empty where there are none.
pub(super) fn cell(
    rows: &[LightRow],
    scene: &str,
    setting: &str,
    text: impl Fn(&LightRow) -> String,
) -> String {
    let mut rows = rows.iter();
    let row = rows.find(|row| row.scene == scene && row.setting == setting);
    row.map_or(String::new(), text)
}

/// A table of errors some frames after the changes of these names, a line for each change and setting.
pub(super) fn changes_table(rows: &[LightRow], settings: &[&str], changes: &[&str]) -> String {
    let lines = settings
        .iter()
        .flat_map(|setting| changes.iter().map(move |scene| (setting, scene)));
    let lines = lines.map(|(setting, scene)| {
        let cell = |setting: &str| cell(rows, scene, setting, error_and_bias);
        let frames = FRAMES.map(|frame| cell(&format!("{setting}, frame {frame}")));
        let name = format!("{scene}, {setting}");
        [vec![name], frames.into(), vec![cell(setting)]].concat()
    });
    let [a, b, c] = FRAMES.map(|frame| format!("frame {frame}"));
    table(&["after the change", &a, &b, &c, "settled"], lines)
}

pub(super) fn error_and_bias(row: &LightRow) -> String {
    let [error, bias] = [row.relative_error, row.bias].map(percent);
    format!("{error:.1}% / {bias:+.1}%")
}

pub(super) fn percent(value: Option<f64>) -> f64 {
    100.0 * value.unwrap_or(f64::NAN)
}

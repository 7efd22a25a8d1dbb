//! The arcade: a scene of curved meshes with textures, whose light moves and whose door opens.
//!
//! Its truth is traced when the study runs. Each setting is compared once the light has settled in the usual
//! state; then the light moves, and later the door opens, and the picture is compared with the truth of the new
//! state some frames after the change and once the light has settled again.

use bevy::prelude::*;
use bevy_frugal_lab::{
    boxes::{Agreement, agreement, block_means},
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat},
    meshes::{
        MeshScene, SpawnedScene,
        arcade::{Arcade, ArcadeState},
        move_to, spawn_mesh_scene, trace,
    },
    path_tracer::TraceSettings,
};
use bevy_voxel_gi::{Sky, VoxelGiPlugin, VoxelGiReport, VoxelGiVolume};
use indicatif::ProgressBar;

use crate::{
    page::table,
    plan::ArcadePlan,
    record::ReportAdapter,
    voxel_gi::{
        LightRow,
        render::{MAX_FRAMES, difference, halved, picture, settle},
        settings::Setting,
    },
};

/// Frames after a change at which a picture is compared.
pub const FRAMES: [u32; 3] = [1, 8, 30];

/// The settings of the study that the arcade is measured with.
const SETTINGS: [&str; 5] = [
    "trace",
    "trace per pixel",
    "propagate",
    "trace 16^3",
    "trace 64^3",
];

/// The rows of those settings that are measured in the arcade, and the adapter.
pub fn rows(
    plan: &ArcadePlan,
    settings: &[Setting],
    progress: &ProgressBar,
) -> Result<(Vec<LightRow>, ReportAdapter), HeadlessError> {
    progress.set_message("arcade: path tracing");
    let mut stage = ArcadeApp::new(plan)?;
    let mut rows = Vec::new();
    for setting in settings {
        if SETTINGS.contains(&setting.name.as_str()) {
            progress.set_message(format!("arcade: {}", setting.name));
            rows.extend(stage.rows(setting)?);
        }
    }
    Ok((rows, stage.app.adapter().into()))
}

/// The arcade in Bevy, and its truth.
pub struct ArcadeApp {
    app: HeadlessApp,
    spawned: SpawnedScene,
    states: Vec<StateTruth>,
}

/// A state of the arcade.
struct StateTruth {
    state: ArcadeState,
    scene: MeshScene,
    /// The picture without a volume.
    without: Vec<Vec3>,
    /// Block means of the path-traced light that a volume is to add.
    truth: Vec<Vec3>,
}

impl ArcadeApp {
    /// Traces the truth of all states, and renders them without a volume.
    pub fn new(plan: &ArcadePlan) -> Result<Self, HeadlessError> {
        let arcade = Arcade::new(plan.scene);
        let settings = TraceSettings {
            samples: plan.samples,
            ..default()
        };
        // Twice as wide as the truth, since a pixel of Bevy's has one sample of the geometry.
        let mut app = HeadlessApp::new(
            HeadlessSettings {
                format: TargetFormat::Float32,
                ..HeadlessSettings::with_size(2 * plan.scene.picture, 2 * plan.scene.picture)
            },
            |app| {
                app.add_plugins(VoxelGiPlugin);
            },
        )?;
        let world = app.world_mut();
        let spawned = spawn_mesh_scene(world, &arcade.scene(ArcadeState::Usual));
        // What a volume adds does not depend on shadow maps, which take most of the time of a software driver.
        for mut light in world.query::<&mut PointLight>().iter_mut(world) {
            light.shadow_maps_enabled = false;
        }
        for mut light in world.query::<&mut DirectionalLight>().iter_mut(world) {
            light.shadow_maps_enabled = false;
        }
        app.run_until_ready(MAX_FRAMES)?;
        let mut states = Vec::new();
        for state in ArcadeState::ALL {
            let scene = arcade.scene(state);
            move_to(app.world_mut(), &spawned, &scene);
            app.render_frames(2)?;
            let traced = trace(&scene, &settings);
            states.push(StateTruth {
                state,
                without: picture(&mut app)?,
                truth: block_means(&traced.indirect, traced.width),
                scene,
            });
        }
        Ok(Self {
            app,
            spawned,
            states,
        })
    }

    /// The world of the scene.
    pub fn world_mut(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// The error of a setting in each state.
    pub fn rows(&mut self, setting: &Setting) -> Result<Vec<LightRow>, HeadlessError> {
        let scene = &self.states[0].scene;
        move_to(self.app.world_mut(), &self.spawned, scene);
        let world = self.app.world_mut();
        world.insert_resource(setting.settings.clone());
        let volume = world.spawn(placed(scene, setting.settings.resolution)).id();
        settle(&mut self.app)?;
        let mut rows = Vec::new();
        for (index, state) in self.states.iter().enumerate() {
            if index > 0 {
                // Every change begins with the usual state.
                move_to(self.app.world_mut(), &self.spawned, &self.states[0].scene);
                settle(&mut self.app)?;
                move_to(self.app.world_mut(), &self.spawned, &state.scene);
                let mut rendered = 0;
                for frame in FRAMES {
                    self.app.render_frames(frame - rendered)?;
                    rendered = frame;
                    let name = format!("{}, frame {frame}", setting.name);
                    rows.push(state.row(&mut self.app, name)?);
                }
            }
            settle(&mut self.app)?;
            rows.push(state.row(&mut self.app, setting.name.clone())?);
        }
        self.app.world_mut().despawn(volume);
        // The frame in which a volume ends may still show it.
        self.app.render_frames(2)?;
        Ok(rows)
    }
}

impl StateTruth {
    fn row(&self, app: &mut HeadlessApp, setting: String) -> Result<LightRow, HeadlessError> {
        let added = difference(&picture(app)?, &self.without);
        let width = self.scene.stage.camera.width;
        let Agreement {
            relative_error,
            bias,
        } = agreement(&halved(&added, 2 * width), width, &self.truth);
        Ok(LightRow {
            scene: self.state.name().into(),
            setting,
            bytes: Some(app.world().resource::<VoxelGiReport>().memory),
            relative_error: Some(relative_error),
            bias: Some(bias),
            ..LightRow::default()
        })
    }
}

/// A volume that fits the scene, with its sky.
fn placed(scene: &MeshScene, resolution: u32) -> (VoxelGiVolume, Transform) {
    let (center, size) = scene.volume(resolution);
    let volume = VoxelGiVolume {
        sky: Some(Sky::uniform(LinearRgba::from_vec3(
            scene.stage.sky_radiance,
        ))),
        ..VoxelGiVolume::fixed(size)
    };
    (volume, Transform::from_translation(center))
}

/// A table of the settings in each state, and one of the frames after a change; empty where nothing was measured.
pub fn tables(rows: &[LightRow]) -> String {
    let usual = ArcadeState::Usual.name();
    let settings: Vec<_> = rows.iter().filter(|row| row.scene == usual).collect();
    if settings.is_empty() {
        return String::new();
    }
    let cell = |scene: &str, setting: &str| {
        let mut rows = rows.iter();
        let row = rows.find(|row| row.scene == scene && row.setting == setting);
        row.map_or(String::new(), error_and_bias)
    };
    let names = ArcadeState::ALL.map(ArcadeState::name);
    let usual = settings.iter().map(|row| {
        let cells = names.map(|scene| cell(scene, &row.setting));
        [vec![row.setting.clone()], cells.into()].concat()
    });
    let heads = [&["setting"], &names[..]].concat();
    let usual = table(&heads, usual);
    let changes = settings
        .iter()
        .flat_map(|row| names[1..].iter().map(move |scene| (row, scene)));
    let changes = changes.map(|(row, scene)| {
        let frames = FRAMES.map(|frame| cell(scene, &format!("{}, frame {frame}", row.setting)));
        let name = format!("{scene}, {}", row.setting);
        [vec![name], frames.into(), vec![cell(scene, &row.setting)]].concat()
    });
    let [a, b, c] = FRAMES.map(|frame| format!("frame {frame}"));
    let changes = table(&["after the change", &a, &b, &c, "settled"], changes);
    format!("\n{usual}\n{changes}")
}

fn error_and_bias(row: &LightRow) -> String {
    let percent = |value: Option<f64>| 100.0 * value.unwrap_or(f64::NAN);
    format!(
        "{:.1}% / {:+.1}%",
        percent(row.relative_error),
        percent(row.bias)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_a_line_of_states_and_changes_one_of_frames() {
        let row = |scene: ArcadeState, setting: &str, error| LightRow {
            scene: scene.name().into(),
            setting: setting.into(),
            relative_error: Some(error),
            bias: Some(-error),
            ..LightRow::default()
        };
        assert_eq!(tables(&[]), "");
        let mut rows = vec![row(ArcadeState::DoorOpen, "trace, frame 8", 0.5)];
        for (i, state) in ArcadeState::ALL.into_iter().enumerate() {
            rows.push(row(state, "trace", 0.1 * i as f64));
        }
        let text = tables(&rows);
        for line in [
            "| trace | 0.0% / -0.0% | 10.0% / -10.0% | 20.0% / -20.0% |",
            "| arcade, door open, trace |  | 50.0% / -50.0% |  | 20.0% / -20.0% |",
        ] {
            assert!(text.lines().any(|found| found == line), "{text}");
        }
    }
}

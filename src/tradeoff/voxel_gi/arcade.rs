//! The arcade: a scene of curved meshes with textures, whose light moves and whose door opens.
//!
//! Its truth is traced when the study runs. Each setting is compared once the light has settled in the usual
//! state; then the light moves, and later the door opens, and the picture is compared with the truth of the new
//! state some frames after the change and once the light has settled again.

use bevy::prelude::*;
use bevy_voxel_gi::{Sky, VoxelGiPlugin, VoxelGiReport, VoxelGiVolume};
use indicatif::ProgressBar;

use super::{
    picture::{difference, halved, picture},
    render::{MAX_FRAMES, settle},
    settings::Setting,
};
use crate::{
    boxes::{Agreement, agreement, block_means},
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, TargetFormat},
    meshes::{
        MeshScene, SpawnedScene,
        arcade::{Arcade, ArcadeState},
        move_to, spawn_mesh_scene, trace,
    },
    path_tracer::TraceSettings,
    record::{Measurement, ReportAdapter},
    tradeoff::plan::ArcadePlan,
};

/// What the rows of the arcade are compared with, as records name it.
pub const REFERENCE: &str = "traced by the lab";
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
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered or the light does not settle.
pub fn rows(
    plan: &ArcadePlan,
    settings: &[Setting],
    progress: &ProgressBar,
) -> Result<(Vec<Measurement>, ReportAdapter), HeadlessError> {
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
    ///
    /// # Errors
    /// [`HeadlessError`] when a frame cannot be rendered.
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
    ///
    /// # Errors
    /// [`HeadlessError`] when a frame cannot be rendered or the light does not settle.
    pub fn rows(&mut self, setting: &Setting) -> Result<Vec<Measurement>, HeadlessError> {
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
    fn row(&self, app: &mut HeadlessApp, setting: String) -> Result<Measurement, HeadlessError> {
        let added = difference(&picture(app)?, &self.without);
        let width = self.scene.stage.camera.width;
        let Agreement {
            relative_error,
            bias,
        } = agreement(&halved(&added, 2 * width), width, &self.truth);
        Ok(Measurement {
            scene: self.state.name().into(),
            setting,
            reference: REFERENCE.into(),
            bytes: Some(app.world().resource::<VoxelGiReport>().memory),
            relative_error: Some(relative_error),
            bias: Some(bias),
            ..Measurement::default()
        })
    }
}

/// A volume that fits the scene, with its sky.
fn placed(scene: &MeshScene, resolution: u32) -> (VoxelGiVolume, Transform) {
    let (center, size) = scene.volume(resolution);
    let volume = VoxelGiVolume {
        size,
        sky: Sky::uniform(LinearRgba::from_vec3(scene.stage.sky_radiance)),
        ..default()
    };
    (volume, Transform::from_translation(center))
}

//! The CPU's time for a frame in which something moves, with global illumination and without: `tradeoff motion`.
//!
//! On a software driver it is the work of the GPU, too. It is the time of all threads of the process, so that what other
//! programs do hardly matters.

use std::time::Duration;

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::{HeadlessApp, HeadlessError, HeadlessSettings},
    meshes::{
        SpawnedScene, spawn_mesh_scene,
        town::{Town, TownCamera, TownState},
    },
};
use bevy_voxel_gi::{Sky, VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume};
use clap::{Parser, ValueEnum};
use cpu_time::ProcessTime;

use crate::{
    page::table,
    run::TradeoffError,
    voxel_gi::render::{MAX_FRAMES, settle},
};

/// The command line.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// Only this motion; may be repeated.
    #[arg(long, value_enum)]
    only: Vec<Motion>,
    /// Frames that are measured, after a quarter as many.
    #[arg(long, value_name = "N", default_value_t = 40)]
    frames: u32,
    /// Voxels along the edge of a level.
    #[arg(long, value_name = "N", default_value_t = 32)]
    resolution: u32,
}

/// What moves or changes in the town.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Motion {
    /// Nothing.
    Rest,
    /// A box of half a metre, three metres before the camera.
    Box,
    /// The lift, beside the camera in the cellar.
    Lift,
    /// A thousand boxes all over the town.
    Crowd,
    /// The camera, 5 cm in each frame.
    Flight,
    /// The sun, a quarter of a degree in each frame.
    Sun,
    /// The intensity of a point light 200 m away.
    FarLight,
    /// The intensity of a point light in the next house.
    NextHouse,
}

impl Motion {
    fn camera(self) -> TownCamera {
        match self {
            Self::Lift => TownCamera::Cellar,
            Self::NextHouse => TownCamera::Room,
            _ => TownCamera::Yard,
        }
    }
}

/// Size of the picture in pixels.
const PICTURE: [u32; 2] = [240, 136];

/// Measures, and prints a table.
pub fn run(options: &Options) -> Result<(), TradeoffError> {
    let is_chosen = |motion: &&Motion| options.only.is_empty() || options.only.contains(motion);
    let mut lines = Vec::new();
    for motion in Motion::value_variants().iter().filter(is_chosen) {
        let [without, with] = [None, Some(options.resolution)].map(|resolution| {
            let mut scene = Moving::new(*motion, resolution)?;
            if resolution.is_some() {
                settle(&mut scene.app)?;
            }
            scene.times(options.frames)
        });
        let [(median, _), (median_with, most_with)] = [without?, with?];
        lines.push(vec![
            format!("{motion:?}"),
            format!("{median:.0}"),
            format!("{median_with:.0}"),
            format!("{:.0}", median_with - median),
            format!("{:.2}", most_with / median_with),
        ]);
        eprintln!("{}", lines[lines.len() - 1].join(" | "));
    }
    let heads = [
        "what moves",
        "CPU ms a frame without GI",
        "with",
        "more",
        "greatest frame over median",
    ];
    println!("{}", table(&heads, lines));
    Ok(())
}

/// The town, in which something is about to move.
struct Moving {
    app: HeadlessApp,
    spawned: SpawnedScene,
    motion: Motion,
    movers: Vec<Entity>,
    frame: u32,
}

impl Moving {
    /// With the default volume, if a resolution is given.
    fn new(motion: Motion, resolution: Option<u32>) -> Result<Self, HeadlessError> {
        let scene = Town::new(PICTURE[1]).scene(TownState::Usual, motion.camera());
        let settings = HeadlessSettings::with_size(PICTURE[0], PICTURE[1]);
        let mut app = HeadlessApp::new(settings, |app| {
            app.add_plugins(VoxelGiPlugin);
        })?;
        let world = app.world_mut();
        let spawned = spawn_mesh_scene(world, &scene);
        let camera = scene.stage.camera;
        let forward = (camera.target - camera.eye).normalize();
        let light = |range| PointLight {
            range,
            intensity: 1e5,
            ..default()
        };
        let movers = match motion {
            Motion::Box => vec![spawn_box(world, 0.5, camera.eye + 3.0 * forward)],
            Motion::Crowd => {
                let place = |i: usize| Vec3::new((i % 32) as f32, 0.0, (i / 32) as f32) * 2.4;
                let places = (0..1000).map(|i| place(i) + Vec3::new(-38.0, 0.4, -38.0));
                places.map(|place| spawn_box(world, 0.3, place)).collect()
            }
            Motion::FarLight => {
                let place = Transform::from_xyz(200.0, 2.0, 0.0);
                vec![world.spawn((light(20.0), place)).id()]
            }
            Motion::NextHouse => {
                let place = Transform::from_xyz(-1.0, 2.0, -15.0);
                vec![world.spawn((light(8.0), place)).id()]
            }
            Motion::Lift => spawned.parts[1..3].to_vec(),
            Motion::Rest | Motion::Flight | Motion::Sun => Vec::new(),
        };
        if let Some(resolution) = resolution {
            world.insert_resource(VoxelGiSettings {
                resolution,
                ..default()
            });
            let sky = Sky::uniform(LinearRgba::from_vec3(scene.stage.sky_radiance));
            world.spawn(VoxelGiVolume {
                sky: Some(sky),
                ..default()
            });
        }
        app.run_until_ready(MAX_FRAMES)?;
        Ok(Self {
            app,
            spawned,
            motion,
            movers,
            frame: 0,
        })
    }

    /// Moves what moves by the way of a frame.
    fn step(&mut self) {
        self.frame += 1;
        let world = self.app.world_mut();
        let time = self.frame as f32 / 60.0;
        match self.motion {
            Motion::Rest => {}
            Motion::Box | Motion::Crowd => {
                let camera = world.get::<Transform>(self.spawned.camera);
                let along = camera.map_or(Vec3::X, |camera| camera.right().into());
                for (i, &mover) in self.movers.iter().enumerate() {
                    if let Some(mut pose) = world.get_mut::<Transform>(mover) {
                        pose.translation += 0.05 * along * (4.0 * time + i as f32).cos();
                    }
                }
            }
            Motion::Lift => {
                for &mover in &self.movers {
                    if let Some(mut pose) = world.get_mut::<Transform>(mover) {
                        pose.translation.y -= 0.02;
                    }
                }
            }
            Motion::Flight => {
                if let Some(mut pose) = world.get_mut::<Transform>(self.spawned.camera) {
                    let forward = pose.forward();
                    pose.translation += 0.05 * forward;
                }
            }
            Motion::Sun => {
                for &light in &self.spawned.lights {
                    if world.get::<DirectionalLight>(light).is_some()
                        && let Some(mut pose) = world.get_mut::<Transform>(light)
                    {
                        pose.rotate_y(0.25_f32.to_radians());
                    }
                }
            }
            Motion::FarLight | Motion::NextHouse => {
                for &mover in &self.movers {
                    if let Some(mut light) = world.get_mut::<PointLight>(mover) {
                        light.intensity = 1e5 * (1.5 + (9.0 * time).sin());
                    }
                }
            }
        }
    }

    /// The median and the greatest of so many frames in milliseconds.
    fn times(&mut self, frames: u32) -> Result<(f64, f64), HeadlessError> {
        let mut times = Vec::new();
        for frame in 0..frames / 4 + frames {
            self.step();
            let start = ProcessTime::now();
            self.app.render_frames(1)?;
            if frame >= frames / 4 {
                times.push(start.elapsed());
            }
        }
        times.sort();
        let ms = |time: Option<&Duration>| time.map_or(0.0, |time| 1e3 * time.as_secs_f64());
        Ok((ms(times.get(times.len() / 2)), ms(times.last())))
    }
}

fn spawn_box(world: &mut World, size: f32, place: Vec3) -> Entity {
    let mesh = world.add_asset::<Mesh>(Cuboid::from_length(size));
    let material = world.add_asset::<StandardMaterial>(Color::srgb(0.8, 0.4, 0.3));
    let pose = Transform::from_translation(place);
    let parts = (Mesh3d(mesh), MeshMaterial3d(material), pose);
    world.spawn(parts).id()
}

//! Helpers that several test modules share.

pub mod compute;
pub mod logs;
pub mod pool;

use std::{
    fs::OpenOptions,
    io::Write,
    sync::{Condvar, Mutex, PoisonError},
    thread,
    time::{Duration, Instant},
};

use bevy::prelude::*;
pub use bevy_frugal_lab::compose;
use bevy_frugal_lab::compose::Composer;
use bevy_frugal_lab::headless::{HeadlessApp, LabTarget, threads};

static QUEUE: Mutex<Queue> = Mutex::new(Queue {
    running: 0,
    asked: 0,
    served: 0,
});
static MOVED: Condvar = Condvar::new();

/// Apps that run, and tests that wait in the order in which they asked: one that wants to be alone would wait until
/// the end otherwise.
struct Queue {
    running: usize,
    asked: usize,
    served: usize,
}

/// A right to run apps, until it is dropped.
pub struct Gpu {
    apps: usize,
}

impl Gpu {
    fn wait_for(apps: usize) -> Self {
        logs::listen();
        let most = most_apps();
        let mut queue = QUEUE.lock().unwrap_or_else(PoisonError::into_inner);
        let ticket = queue.asked;
        queue.asked += 1;
        let queue = MOVED.wait_while(queue, |queue| {
            queue.served != ticket || queue.running + apps > most
        });
        let mut queue = queue.unwrap_or_else(PoisonError::into_inner);
        queue.served += 1;
        queue.running += apps;
        // A test that is alone has Bevy's threads for itself, as a game has.
        threads::use_one_thread(apps < most);
        MOVED.notify_all();
        Self { apps }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        let mut queue = QUEUE.lock().unwrap_or_else(PoisonError::into_inner);
        queue.running -= self.apps;
        MOVED.notify_all();
        drop(queue);
        let errors = logs::renderer_errors();
        if !thread::panicking() {
            assert!(
                errors.is_empty(),
                "logged, perhaps by an app beside this test's: {errors:#?}"
            );
        }
    }
}

/// Waits until an app may run.
pub fn gpu() -> Gpu {
    Gpu::wait_for(1)
}

/// Waits until no other app runs, for what is measured of the whole process.
pub fn gpu_alone() -> Gpu {
    Gpu::wait_for(most_apps())
}

/// Apps that run at the same time, at most: a software driver compiles an app's pipelines one after the
/// other, and while one app waits for that another can draw.
fn most_apps() -> usize {
    thread::available_parallelism().map_or(1, |cores| cores.get().min(2) + 1)
}

/// A composer with the shaders of an app once they are loaded, which other threads do: when none has come for a while.
pub fn composer(app: &mut HeadlessApp) -> Composer {
    let mut known = 0;
    let mut since = Instant::now();
    while since.elapsed() < Duration::from_millis(200) {
        app.render_frames(1).expect("a frame");
        let count = app.world().resource::<Assets<Shader>>().len();
        if count != known {
            known = count;
            since = Instant::now();
        }
        thread::sleep(Duration::from_millis(5));
    }
    Composer::new(app.world())
}

/// Says that a part of a test is left out, and why. `scripts/test` names a file in `SKIPPED_TESTS` and prints
/// at its end what was appended.
pub fn skipped(what: &str) {
    println!("skipped: {what}");
    let Some(path) = std::env::var_os("SKIPPED_TESTS") else {
        return;
    };
    let file = OpenOptions::new().create(true).append(true).open(&path);
    file.and_then(|mut file| writeln!(file, "{what}"))
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// A cube, lit from the front left, that turns a radian a second.
pub fn lit_cube(app: &mut App) {
    app.add_systems(Startup, spawn_cube)
        .add_systems(Update, turn);
}

#[derive(Component)]
struct Turning;

fn spawn_cube(
    mut commands: Commands,
    target: Res<LabTarget>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        Camera3d::default(),
        target.0.clone(),
        Transform::from_xyz(0.0, 1.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(-1.0, 1.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Turning,
        Mesh3d(meshes.add(Cuboid::default())),
        MeshMaterial3d(materials.add(Color::srgb(0.8, 0.3, 0.1))),
    ));
}

fn turn(time: Res<Time>, mut cubes: Query<&mut Transform, With<Turning>>) {
    for mut transform in &mut cubes {
        transform.rotation = Quat::from_rotation_y(time.elapsed_secs());
    }
}

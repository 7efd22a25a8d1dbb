//! Helpers that several test modules share.

pub mod compute;
pub mod pool;

use std::{
    io::Cursor,
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant},
};

use bevy::{asset::RenderAssetUsages, mesh::PrimitiveTopology, prelude::*};
use bevy_ewa::EwaPlugin;
pub use bevy_frugal_lab::{
    compose,
    testing::{Gpu, drawn, gpu, gpu_alone, renderer_errors, skipped, warned_of},
};
use bevy_frugal_lab::{
    compose::Composer,
    headless::{HeadlessApp, HeadlessSettings, LabTarget, TargetFormat},
    metrics::{mse, psnr_db},
};
use bevy_voxel_gi::VoxelGiPlugin;
use bevy_wavelet_tex::WaveletTexPlugin;
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;
use image::{DynamicImage, ImageFormat, RgbImage};

/// A composer with the shaders of an app once they are loaded, which other threads do: when none has come for a while.
pub fn composer(app: &mut HeadlessApp) -> Composer {
    let mut known = 0;
    let mut since = Instant::now();
    while since.elapsed() < Duration::from_millis(1000) {
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

/// Renders frames until there is what `find` looks for, while other threads load what it depends on.
#[track_caller]
pub fn wait_for<T>(
    app: &mut HeadlessApp,
    mut find: impl FnMut(&mut HeadlessApp) -> Option<T>,
) -> T {
    for _ in 0..500 {
        app.render_frames(1).expect("a frame");
        if let Some(found) = find(app) {
            return found;
        }
        thread::sleep(Duration::from_millis(5));
    }
    panic!("500 frames have not brought it");
}

/// PSNR in dB.
pub fn psnr(reference: &RgbImage, test: &RgbImage) -> f64 {
    psnr_db(mse(reference, test).expect("equal sizes"))
}

/// An app of a small picture.
#[track_caller]
pub fn headless(width: u32, height: u32, build: impl FnOnce(&mut App)) -> HeadlessApp {
    HeadlessApp::new(HeadlessSettings::with_size(width, height), build).expect("an app")
}

/// Settings of an app with a picture of floats.
pub fn float_settings(width: u32, height: u32) -> HeadlessSettings {
    HeadlessSettings {
        format: TargetFormat::Float32,
        ..HeadlessSettings::with_size(width, height)
    }
}

/// Adds all four plugins, none of which does anything yet.
pub fn add_plugins(app: &mut App) {
    app.add_plugins((
        WaveletTexPlugin,
        YCoCgFrameBufferPlugin,
        EwaPlugin::OPT_IN,
        VoxelGiPlugin,
    ));
}

/// Saves a picture where `TEST_PICTURES` names a folder, to look at.
pub fn keep(name: &str, picture: &RgbImage) {
    if let Some(folder) = std::env::var_os("TEST_PICTURES") {
        let path = Path::new(&folder).join(format!("{name}.png"));
        picture.save(path).expect("a writable folder");
    }
}

/// The bytes of an image's file.
pub fn image_file(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image
        .into()
        .write_to(&mut bytes, format)
        .expect("an image file");
    bytes.into_inner()
}

/// A mesh of positions alone.
pub fn triangle_mesh(topology: PrimitiveTopology, positions: Vec<[f32; 3]>) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
}

/// A folder of assets that goes with the test.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("frugal-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Self(folder)
    }

    pub fn with(self, name: &str, bytes: &[u8]) -> Self {
        std::fs::write(self.0.join(name), bytes).expect("a file");
        self
    }

    /// The settings of an app that loads its assets from here.
    pub fn settings(&self, width: u32, height: u32) -> HeadlessSettings {
        HeadlessSettings {
            asset_folder: self.0.to_string_lossy().into_owned(),
            ..HeadlessSettings::with_size(width, height)
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A cube, lit from the front left, that turns a radian a second.
pub fn lit_cube(app: &mut App) {
    app.add_systems(Startup, spawn_cube)
        .add_systems(Update, turn);
}

#[derive(Component)]
struct Turning;

fn spawn_cube(world: &mut World) {
    spawn_camera_and_light(world, Vec3::new(0.0, 1.5, 3.0), ());
    let mesh = Mesh3d(world.add_asset(Cuboid::default()));
    let material = world.add_asset::<StandardMaterial>(Color::srgb(0.8, 0.3, 0.1));
    world.spawn((Turning, mesh, MeshMaterial3d(material)));
}

/// Spawns a camera that looks from here at the origin, and a light from the front left.
pub fn spawn_camera_and_light(world: &mut World, eye: Vec3, own: impl Bundle) {
    let look = |from: Vec3| Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
    let target = world.resource::<LabTarget>().0.clone();
    world.spawn((Camera3d::default(), target, look(eye), own));
    let light = Vec3::new(-1.0, 1.0, 2.0);
    world.spawn((DirectionalLight::default(), look(light)));
}

fn turn(time: Res<Time>, mut cubes: Query<&mut Transform, With<Turning>>) {
    for mut transform in &mut cubes {
        transform.rotation = Quat::from_rotation_y(time.elapsed_secs());
    }
}

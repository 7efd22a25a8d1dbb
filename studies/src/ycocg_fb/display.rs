//! The frames of a camera, scene-linear and as a display shows them, and Bevy's tone mapping on the CPU, for frames that
//! no camera has drawn.
//!
//! The curve is not written a second time: a camera shows every combination of channels on a grid,
//! and what comes out is the table. Grid and interpolation are those of Tony McMapface, Bevy's
//! default, whose own table has 48 steps of `x / (1 + x)` an axis; so its nodes are met exactly.

use bevy::{
    camera::Hdr, core_pipeline::tonemapping::Tonemapping, image::ImageSampler, prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_frugal_lab::{
    content::texture,
    headless::{
        HeadlessApp, HeadlessError, HeadlessSettings, LabTarget, Rgba32FImage, TargetFormat,
        pixel_camera,
    },
    scenes::ycocg_fb::scenes::{TestScene, add},
};
use bevy_ycocg_fb::{
    FrameBufferQuality, YCoCgFrameBufferPlugin, reference::pack::srgb_from_linear,
};
use half::f16;
use image::RgbImage;
use rayon::prelude::*;

use crate::{record::ReportAdapter, ycocg_fb::Frame};

const STEPS: u32 = 48;

const SIZE: [u32; 2] = [STEPS * 8, STEPS * STEPS / 8];

/// A table of display-linear colours.
#[derive(Clone, Debug)]
pub struct ToneMap {
    /// Red runs fastest, then green, then blue.
    table: Vec<Vec3>,
    adapter: ReportAdapter,
}

impl ToneMap {
    /// Lets a camera fill the table.
    pub fn capture() -> Result<Self, HeadlessError> {
        let settings =
            HeadlessSettings::with_size(SIZE[0], SIZE[1]).in_format(TargetFormat::Float32);
        let mut app = HeadlessApp::new(settings, |app| {
            let camera = pixel_camera(app.world().resource::<LabTarget>(), SIZE);
            let mut camera = app.world_mut().spawn(camera);
            camera.insert((Hdr, Tonemapping::default()));
            spawn_grid(app.world_mut());
        })?;
        app.run_until_ready(crate::MAX_FRAMES)?;
        let picture = app.capture_f32()?;
        let table = picture.pixels.iter().map(|p| Vec3::new(p[0], p[1], p[2]));
        Ok(Self {
            table: table.collect(),
            adapter: app.adapter().into(),
        })
    }

    pub fn adapter(&self) -> &ReportAdapter {
        &self.adapter
    }

    /// A scene-linear frame as a display shows it: sRGB-encoded, not rounded.
    pub fn display(&self, frame: &Frame) -> Frame {
        let encoded = frame.pixels.par_iter().map(|color| {
            let shown = self.lookup(Vec3::from_array(*color)).to_array();
            shown.map(|c| srgb_from_linear(c.clamp(0.0, 1.0)))
        });
        Frame {
            size: frame.size,
            pixels: encoded.collect(),
        }
    }

    /// The display-linear colour of a scene-linear one.
    fn lookup(&self, color: Vec3) -> Vec3 {
        let color = color.max(Vec3::ZERO).min(Vec3::splat(65504.0));
        let position = color / (color + 1.0) * (STEPS - 1) as f32;
        let low = position.floor().min(Vec3::splat((STEPS - 2) as f32));
        let part = position - low;
        let [x, y, z] = low.to_array().map(|v| v as usize);
        let side = STEPS as usize;
        let at = |dx: usize, dy: usize, dz: usize| -> Vec3 {
            self.table[x + dx + side * (y + dy + side * (z + dz))]
        };
        let row = |dy: usize, dz: usize| at(0, dy, dz).lerp(at(1, dy, dz), part.x);
        let plane = |dz: usize| row(0, dz).lerp(row(1, dz), part.y);
        plane(0).lerp(plane(1), part.z)
    }
}

/// The scene-linear value of a step; the last stands for infinity.
fn value(step: u32) -> f32 {
    let s = step as f32 / (STEPS - 1) as f32;
    (s / (1.0 - s)).min(65504.0)
}

fn spawn_grid(world: &mut World) {
    let texels = (0..STEPS.pow(3)).flat_map(|i| {
        let [r, g, b] = [1, STEPS, STEPS * STEPS].map(|stride| value(i / stride % STEPS));
        [r, g, b, 1.0].map(|v| f16::from_f32(v).to_le_bytes())
    });
    let texels = texels.flatten().collect();
    let mut image = texture(SIZE, TextureFormat::Rgba16Float, 1, texels);
    image.sampler = ImageSampler::nearest();
    let image = world.add_asset(image);
    let material = StandardMaterial {
        unlit: true,
        ..StandardMaterial::from(image)
    };
    add(
        world,
        Rectangle::new(SIZE[0] as f32, SIZE[1] as f32),
        material,
        Transform::default(),
    );
}

/// Frames until a change of the camera is in its picture.
const SETTLING_FRAMES: u32 = 3;

/// The frame of Bevy's own camera before tone mapping: scene-linear, as its main texture holds it.
pub fn hdr_frame(scene: &TestScene, size: [u32; 2]) -> Result<Rgba32FImage, HeadlessError> {
    let (mut app, _) = scene_app(scene, size, TargetFormat::Float32, Tonemapping::None)?;
    app.capture_f32()
}

/// What a display shows of Bevy's own camera, with Bevy's default tone mapping, and then of the
/// same camera in each of these qualities.
pub fn display_frames(
    scene: &TestScene,
    size: [u32; 2],
    qualities: &[FrameBufferQuality],
) -> Result<(RgbImage, Vec<RgbImage>), HeadlessError> {
    let tonemapping = Tonemapping::default();
    let (mut app, camera) = scene_app(scene, size, TargetFormat::Srgb8, tonemapping)?;
    let bevy = app.capture_rgb8()?;
    let packed = qualities.iter().map(|&quality| {
        app.world_mut().entity_mut(camera).insert(quality);
        app.render_frames(SETTLING_FRAMES)?;
        app.capture_rgb8()
    });
    let packed = packed.collect::<Result<_, _>>()?;
    Ok((bevy, packed))
}

/// An app that shows a scene, with every pipeline compiled and a frame rendered, and its camera.
fn scene_app(
    scene: &TestScene,
    size: [u32; 2],
    format: TargetFormat,
    tonemapping: Tonemapping,
) -> Result<(HeadlessApp, Entity), HeadlessError> {
    let settings = HeadlessSettings::with_size(size[0], size[1]).in_format(format);
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(YCoCgFrameBufferPlugin);
    })?;
    let camera = scene.spawn(app.world_mut(), size.into(), tonemapping);
    app.run_until_ready(crate::MAX_FRAMES)?;
    Ok((app, camera))
}

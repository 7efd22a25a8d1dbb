//! The frames of a camera: scene-linear, and as a display shows them.

use bevy::{core_pipeline::tonemapping::Tonemapping, prelude::*};
use bevy_ycocg_fb::{FrameBufferQuality, YCoCgFrameBufferPlugin};
use image::RgbImage;

use bevy_frugal_lab::{
    headless::{HeadlessApp, HeadlessError, HeadlessSettings, Rgba32FImage, TargetFormat},
    scenes::ycocg_fb::scenes::TestScene,
};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;

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
    let settings = HeadlessSettings {
        format,
        ..HeadlessSettings::with_size(size[0], size[1])
    };
    let mut app = HeadlessApp::new(settings, |app| {
        app.add_plugins(YCoCgFrameBufferPlugin);
    })?;
    let camera = scene.spawn(app.world_mut(), size.into(), tonemapping);
    app.run_until_ready(MAX_FRAMES)?;
    Ok((app, camera))
}

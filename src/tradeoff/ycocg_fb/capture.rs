//! The frames of a camera: scene-linear, and as a display shows them.

use bevy::{core_pipeline::tonemapping::Tonemapping, prelude::*};
use image::RgbImage;

use super::scenes::TestScene;
use crate::headless::{HeadlessApp, HeadlessError, HeadlessSettings, Rgba32FImage, TargetFormat};

/// Frames before which every pipeline must have been compiled.
const MAX_FRAMES: u32 = 200;

/// What makes a camera another one than Bevy's own: plugins before, components after it is spawned.
#[derive(Clone, Copy)]
pub struct Dress {
    /// Adds plugins to the app.
    pub app: fn(&mut App),
    /// Adds components to the camera.
    pub camera: fn(&mut EntityWorldMut),
}

impl Dress {
    /// Bevy's own camera, with an `Rgba16Float` target.
    pub const BEVY: Self = Self {
        app: |_| {},
        camera: |_| {},
    };
}

/// An app that shows a scene, with every pipeline compiled and a frame rendered.
///
/// # Errors
/// Those of the adapter and of rendering.
pub fn scene_app(
    scene: &TestScene,
    size: [u32; 2],
    format: TargetFormat,
    tonemapping: Tonemapping,
    dress: Dress,
) -> Result<HeadlessApp, HeadlessError> {
    let settings = HeadlessSettings {
        format,
        ..HeadlessSettings::with_size(size[0], size[1])
    };
    let mut app = HeadlessApp::new(settings, |app| {
        (dress.app)(app);
        let camera = scene.spawn(app.world_mut(), size.into(), tonemapping);
        (dress.camera)(&mut app.world_mut().entity_mut(camera));
    })?;
    app.run_until_ready(MAX_FRAMES)?;
    Ok(app)
}

/// The frame before tone mapping: scene-linear, as the camera's main texture holds it.
///
/// # Errors
/// Those of the adapter and of rendering.
pub fn hdr_frame(
    scene: &TestScene,
    size: [u32; 2],
    dress: Dress,
) -> Result<Rgba32FImage, HeadlessError> {
    scene_app(scene, size, TargetFormat::Float32, Tonemapping::None, dress)?.capture_f32()
}

/// The frame as a display shows it, with Bevy's default tone mapping.
///
/// # Errors
/// Those of the adapter and of rendering.
pub fn display_frame(
    scene: &TestScene,
    size: [u32; 2],
    dress: Dress,
) -> Result<RgbImage, HeadlessError> {
    let tonemapping = Tonemapping::default();
    scene_app(scene, size, TargetFormat::Srgb8, tonemapping, dress)?.capture_rgb8()
}

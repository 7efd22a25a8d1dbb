//! Scenes of the lab with their settings and their split line.

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::HeadlessApp,
    runner::{
        Options, Scene, SceneSetting, SceneSettings, SettingKind, Split, pictures::headless_app,
    },
};
use image::RgbImage;

pub fn app(scene: &'static dyn Scene, [width, height]: [u32; 2], set: &[&str]) -> HeadlessApp {
    headless_app(scene, &Options::picture(width, height, set)).expect("an app")
}

pub fn set(app: &mut HeadlessApp, text: &str) {
    let mut settings = app.world_mut().resource_mut::<SceneSettings>();
    settings.set(text).expect("a setting with this value");
}

/// The value of a setting that nobody sets.
pub fn default_value(setting: &SceneSetting) -> String {
    let settings = SceneSettings::new(vec![setting.clone()]);
    settings.iter().next().expect("a setting").1.to_string()
}

/// All values of a setting, or the least and the greatest.
pub fn values(setting: &SceneSetting) -> Vec<String> {
    match &setting.kind {
        SettingKind::Choice { names, .. } => names.iter().map(ToString::to_string).collect(),
        SettingKind::Toggle { .. } => vec!["true".into(), "false".into()],
        SettingKind::Integer { range, .. } => {
            vec![range.start().to_string(), range.end().to_string()]
        }
        SettingKind::Float { range, .. } => {
            vec![range.start().to_string(), range.end().to_string()]
        }
    }
}

/// The picture with the line at `position`. Time stands still from then on.
pub fn picture(app: &mut HeadlessApp, position: f32) -> RgbImage {
    app.world_mut().insert_resource(Split { position });
    // Frames are short while the processor traces paths beside them.
    app.run_until_ready(20_000).expect("ready");
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.capture_rgb8().expect("a picture")
}

/// What is before the line, and what is after it.
pub fn sides(app: &mut HeadlessApp) -> [RgbImage; 2] {
    [1.0, 0.0].map(|position| picture(app, position))
}

/// One picture up to column `line`, and the other from there on.
pub fn joined([before, after]: [&RgbImage; 2], line: u32) -> RgbImage {
    let (width, height) = before.dimensions();
    RgbImage::from_fn(width, height, |x, y| {
        *(if x < line { before } else { after }).get_pixel(x, y)
    })
}

//! The headless run of a scene: before, after, their difference, and the figures.

use std::{
    cmp::Ordering,
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
};

use bevy::{
    math::{URect, UVec2},
    time::{Time, Virtual},
};
use image::RgbImage;
use indicatif::ProgressBar;
use serde::Serialize;
use thiserror::Error;

use crate::{
    headless::{AdapterInfo, FrameTimes, HeadlessApp, HeadlessError, HeadlessSettings},
    metrics::{self, DEFAULT_PIXELS_PER_DEGREE, SizeMismatch, flip, heat_map},
    runner::{
        MemoryFigures, Notes, Options, PictureArea, Scene, SceneImage, SettingError, SettingValue,
        Side, Size, Split, split,
    },
};

/// Frames after which a scene must be ready; most are within ten.
const MAX_FRAMES: u32 = 2000;

#[derive(Debug, Error)]
pub enum RunError {
    /// A setting does not fit.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A picture could not be rendered.
    #[error(transparent)]
    Headless(#[from] HeadlessError),
    #[error(transparent)]
    Size(#[from] SizeMismatch),
    /// A file could not be written.
    #[error("cannot write `{}`: {source}", .path.display())]
    Write { path: PathBuf, source: io::Error },
    /// There is no display to open a window on.
    #[error(
        "there is no display for a window: set DISPLAY or WAYLAND_DISPLAY, or run with --headless DIR"
    )]
    NoDisplay,
    #[error("there is no scene `{name}`; the scenes are: {}", .names.join(", "))]
    NoScene {
        name: String,
        names: Vec<&'static str>,
    },
    /// The program could not be started again with another scene.
    #[error("cannot start `{}`: {source}", .program.display())]
    Start { program: PathBuf, source: io::Error },
    #[error("the window ended with an error, see above")]
    Window,
}

#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    pub scene: &'static str,
    pub plugin: &'static str,
    /// Width of the pictures in pixels.
    pub width: u32,
    /// Height of the pictures in pixels.
    pub height: u32,
    pub adapter: AdapterInfo,
    pub settings: BTreeMap<&'static str, SettingValue>,
    /// Mean squared error of after against before, in squared 8-bit units.
    pub mse: f64,
    /// PSNR of after against before in dB; null when they are equal.
    pub psnr_db: Option<f64>,
    /// Mean FLIP error, 0 to 1.
    pub flip: f64,
    /// Largest difference of a channel, in 8-bit units.
    pub max_error: u8,
    /// Frame times of "before".
    pub before: FrameTimes,
    /// Frame times of "after".
    pub after: FrameTimes,
    /// Memory on the GPU in bytes, as the scene reports it.
    pub memory: BTreeMap<String, u64>,
    /// What the scene has to say.
    pub notes: BTreeMap<String, String>,
}

impl Outcome {
    pub fn json_line(&self) -> String {
        // Plain structures with text keys always serialise.
        serde_json::to_string(self).unwrap_or_else(|error| format!("{{\"error\":\"{error}\"}}"))
    }
}

/// Builds the headless app of `scene`; its time starts once it is ready.
pub fn headless_app(scene: &'static dyn Scene, options: &Options) -> Result<HeadlessApp, RunError> {
    let settings = options.settings(scene)?;
    let Size { width, height } = options.size;
    let headless = HeadlessSettings {
        adapter_name: options.adapter.clone(),
        ..HeadlessSettings::with_size(width, height)
    };
    let image = SceneImage(options.image.clone());
    Ok(HeadlessApp::new(headless, move |app| {
        app.insert_resource(settings)
            .insert_resource(image)
            .insert_resource(PictureArea(URect::from_corners(
                UVec2::ZERO,
                UVec2::new(width, height),
            )))
            .init_resource::<MemoryFigures>()
            .init_resource::<Notes>();
        split::add_cameras(app, scene);
        scene.build(app);
    })?)
}

/// Steps by which [`render_headless`] advances its progress bar.
pub const STEPS: u64 = 3;

/// Renders `scene` and writes `NAME_before.png`, `NAME_after.png` and `NAME_difference.png` (the
/// FLIP error, from black to white) into `folder`, which is created; with [`Options::split`] only
/// `NAME.jpg`, which has both sides.
///
/// Both pictures show the same moment, the start: the scene's time stands still.
pub fn render_headless(
    scene: &'static dyn Scene,
    options: &Options,
    folder: &Path,
    progress: &ProgressBar,
) -> Result<Outcome, RunError> {
    let mut app = headless_app(scene, options)?;
    std::fs::create_dir_all(folder).map_err(|source| RunError::Write {
        path: folder.into(),
        source,
    })?;
    let (before, before_times) = render_side(&mut app, Side::Before, options.frames)?;
    progress.inc(1);
    let (after, after_times) = render_side(&mut app, Side::After, options.frames)?;
    progress.inc(1);
    let error = metrics::compare(&before, &after)?;
    if options.split {
        let path = folder.join(scene.name()).with_extension("jpg");
        save(&halves(&before, &after), &path)?;
    } else {
        let map = flip::flip_map(&before, &after, DEFAULT_PIXELS_PER_DEGREE)?;
        let difference = heat_map::flip_heat_map(&map);
        for (image, part) in [
            (&before, "before"),
            (&after, "after"),
            (&difference, "difference"),
        ] {
            save(image, &folder.join(picture_name(scene.name(), part)))?;
        }
    }
    progress.inc(1);
    let settings = options.settings(scene)?;
    Ok(Outcome {
        scene: scene.name(),
        plugin: scene.plugin(),
        width: options.size.width,
        height: options.size.height,
        adapter: app.adapter().clone(),
        settings: settings
            .iter()
            .map(|(setting, value)| (setting.name, value))
            .collect(),
        mse: error.mse,
        psnr_db: error.psnr_db.is_finite().then_some(error.psnr_db),
        flip: error.flip,
        max_error: error.max_error,
        before: before_times,
        after: after_times,
        memory: app.world().resource::<MemoryFigures>().0.clone(),
        notes: app.world().resource::<Notes>().0.clone(),
    })
}

/// File name of a picture; `part` is `before`, `after` or `difference`.
pub fn picture_name(scene: &str, part: &str) -> String {
    format!("{scene}_{part}.png")
}

/// Shows one side only, and stops the scene's time once it is ready.
pub fn show(app: &mut HeadlessApp, side: Side) -> Result<(), HeadlessError> {
    let position = match side {
        Side::Before => 1.0,
        Side::After => 0.0,
    };
    app.world_mut().insert_resource(Split { position });
    app.run_until_ready(MAX_FRAMES)?;
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    Ok(())
}

fn render_side(
    app: &mut HeadlessApp,
    side: Side,
    frames: u32,
) -> Result<(RgbImage, FrameTimes), RunError> {
    show(app, side)?;
    let times = app.measure_frames(frames)?;
    Ok((app.capture_rgb8()?, times))
}

/// The left half of one and the right half of the other, with a line between them.
fn halves(before: &RgbImage, after: &RgbImage) -> RgbImage {
    let middle = before.width() / 2;
    RgbImage::from_fn(before.width(), before.height(), |x, y| {
        match x.cmp(&middle) {
            Ordering::Less => *before.get_pixel(x, y),
            Ordering::Equal => image::Rgb([255; 3]),
            Ordering::Greater => *after.get_pixel(x, y),
        }
    })
}

fn save(image: &RgbImage, path: &Path) -> Result<(), RunError> {
    image.save(path).map_err(|error| RunError::Write {
        path: path.into(),
        source: io::Error::other(error),
    })
}

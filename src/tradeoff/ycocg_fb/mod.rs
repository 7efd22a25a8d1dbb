//! The study of `bevy_ycocg_fb`: how close each way to store a frame comes to Bevy's own
//! `Rgba16Float` camera, on scenes that are hard in different ways.
//!
//! The frame of Bevy's camera is captured before tone mapping and stored and loaded on the CPU,
//! with the [reference](bevy_ycocg_fb::reference) of the plugin and with the alternatives; then both
//! are tone-mapped as Bevy does by default and compared in 8 bits. The pictures of packed cameras
//! ([`Picture::Camera`]) are rendered by the plugin and tone-mapped by Bevy, and compared with Bevy's
//! own camera treated so; where there is only a frame and no scene they are computed too.
//!
//! `bytes` are those of colour at one sample a pixel, as stored, without what it is resolved to;
//! `fetches` are those of the pass that reads it.
//!
//! | module | gives |
//! | --- | --- |
//! | [`scenes`] | the scenes |
//! | [`mod@capture`] | their frames |
//! | [`cameras`], [`cost`] | cameras, their memory and frame times |
//! | [`stress`] | the same frames at other exposures, and photographs |
//! | [`frame`] | a picture of floats |
//! | [`mod@summary`] | what a user chooses between |
//! | [`tone_map`] | Bevy's tone mapping on the CPU |
//! | [`mod@settings`] | what is measured, by name |
//! | [`ablation`] | the steps from the thesis's filter to the plugin's |
//! | [`alternatives`] | other ways to save the same memory (thesis 4.6) |
//! | [`layouts`] | other pixels that store Co |
//! | [`mod@surface`], [`compression`] | frames as textures store them, and what lossless compression leaves |

pub mod ablation;
pub mod alternatives;
pub mod cameras;
pub mod capture;
pub mod compression;
pub mod cost;
pub mod frame;
pub mod layouts;
pub mod scenes;
pub mod settings;
pub mod stress;
pub mod summary;
pub mod surface;
pub mod tone_map;

use image::RgbImage;
use indicatif::ProgressBar;

use self::{
    capture::{display_frames, hdr_frame},
    frame::Frame,
    scenes::{SCENES, TestScene},
    settings::{Picture, REFERENCE, Setting, settings},
    surface::surfaces,
    tone_map::ToneMap,
};
use super::{
    plan::Plan,
    study::{Study, TradeoffError},
};
use crate::{
    metrics::compare,
    record::{Measurement, Report},
};

pub const STUDY: Study = Study {
    name: "ycocg_fb",
    measure,
    summary: summary::summary,
    tables: compression::chapter,
};

fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
    let Some(size) = plan.frame else {
        return Ok(Report::default());
    };
    let settings = settings();
    let photographs = stress::photographs(plan, progress)?;
    let steps = SCENES.len() + stress::EXPOSURES.len() + photographs.len() + cost::STEPS;
    progress.set_length(steps as u64);

    progress.set_message("tone mapping");
    let tone_map = ToneMap::capture()?;
    let mut report = Report {
        adapter: tone_map.adapter().clone(),
        ..Report::default()
    };
    for scene in &SCENES {
        progress.set_message(scene.name);
        let rows = scene_rows(scene, size, &settings, &tone_map)?;
        report.measurements.extend(rows);
        progress.inc(1);
    }
    let exposed = stress::exposures(size)?;
    for (name, frame) in exposed.into_iter().chain(photographs) {
        progress.set_message(name.clone());
        let rows = simulated_rows(&name, &frame, &settings, &tone_map)?;
        report.measurements.extend(rows);
        progress.inc(1);
    }
    report.measurements.extend(cost::rows(plan, progress)?);
    Ok(report)
}

/// The rows of a scene: all settings, the reference first.
pub fn scene_rows(
    scene: &TestScene,
    size: [u32; 2],
    settings: &[Setting],
    tone_map: &ToneMap,
) -> Result<Vec<Measurement>, TradeoffError> {
    let frame = Frame::from(&hdr_frame(scene, size)?);
    let computed: Vec<_> = settings
        .iter()
        .filter(|setting| !matches!(setting.picture, Picture::Camera { .. }))
        .copied()
        .collect();
    let mut rows = simulated_rows(scene.name, &frame, &computed, tone_map)?;
    let surfaces = surfaces(&frame, &tone_map.display(&frame));
    rows.extend(compression::rows(scene.name, &surfaces));
    let cameras: Vec<_> = settings
        .iter()
        .filter_map(|setting| match setting.picture {
            Picture::Camera { quality, .. } => Some((setting, quality)),
            Picture::SceneLinear(_) | Picture::Display(_) => None,
        })
        .collect();
    let qualities: Vec<_> = cameras.iter().map(|(_, quality)| *quality).collect();
    let (bevy, pictures) = display_frames(scene, size, &qualities)?;
    for ((setting, _), picture) in cameras.iter().zip(&pictures) {
        rows.push(row(scene.name, setting, &bevy, picture)?);
    }
    Ok(rows)
}

/// The rows of a scene-linear frame: all settings, computed, the reference first.
pub fn simulated_rows(
    scene: &str,
    frame: &Frame,
    settings: &[Setting],
    tone_map: &ToneMap,
) -> Result<Vec<Measurement>, TradeoffError> {
    let display = tone_map.display(frame);
    let reference = display.to_rgb8();
    let itself = Setting {
        name: REFERENCE,
        bytes_per_pixel: 8.0,
        fetches: 1.0,
        picture: Picture::SceneLinear(Frame::clone),
    };
    let mut rows = vec![row(scene, &itself, &reference, &reference)?];
    for setting in settings {
        let picture = match setting.picture {
            Picture::SceneLinear(store) | Picture::Camera { store, .. } => {
                tone_map.display(&store(frame))
            }
            Picture::Display(store) => store(&display),
        };
        rows.push(row(scene, setting, &reference, &picture.to_rgb8())?);
    }
    Ok(rows)
}

fn row(
    scene: &str,
    setting: &Setting,
    reference: &RgbImage,
    picture: &RgbImage,
) -> Result<Measurement, TradeoffError> {
    let pixels = f64::from(reference.width()) * f64::from(reference.height());
    Ok(Measurement {
        scene: scene.into(),
        setting: setting.name.into(),
        reference: REFERENCE.into(),
        bytes: Some((pixels * setting.bytes_per_pixel) as u64),
        fetches: Some(setting.fetches),
        ..Measurement::from(&compare(reference, picture)?)
    })
}

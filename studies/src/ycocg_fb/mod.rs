//! The study of `bevy_ycocg_fb`: how close each way to store a frame comes to Bevy's own
//! `Rgba16Float` camera, on scenes that are hard in different ways.
//!
//! The frame of Bevy's camera is captured before tone mapping and stored and loaded on the CPU,
//! with the [reference](bevy_ycocg_fb::reference) of the plugin; then both
//! are tone-mapped as Bevy does by default and compared in 8 bits. The pictures of packed cameras
//! ([`Picture::Camera`]) are rendered by the plugin and tone-mapped by Bevy, and compared with Bevy's
//! own camera treated so.
//!
//! `bytes` are those of colour at one sample a pixel, as stored, without what it is resolved to;
//! `fetches` are those of the pass that reads it.
//!
//! | module | gives |
//! | --- | --- |
//! | [`mod@capture`] | their frames |
//! | [`cameras`], [`cost`] | cameras, their memory and frame times |
//! | [`frame`] | a picture of floats |
//! | [`mod@summary`] | what a user chooses between |
//! | [`tone_map`] | Bevy's tone mapping on the CPU |
//! | [`mod@settings`] | what is measured, by name |

pub mod cameras;
pub mod capture;
pub mod cost;
pub mod frame;
pub mod settings;
pub mod summary;
pub mod tone_map;

use image::RgbImage;
use indicatif::ProgressBar;

use self::{
    capture::{display_frames, hdr_frame},
    frame::Frame,
    settings::{Picture, REFERENCE, Setting, settings},
    tone_map::ToneMap,
};
use super::{
    plan::Plan,
    study::{Study, TradeoffError},
};
use crate::record::{Measurement, Report};
use bevy_frugal_lab::{
    metrics::compare,
    scenes::ycocg_fb::scenes::{SCENES, TestScene},
};

pub const STUDY: Study = Study {
    name: "ycocg_fb",
    measure,
    summary: summary::summary,
    tables: |_| String::new(),
};

fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
    let Some(size) = plan.frame else {
        return Ok(Report::default());
    };
    let settings = settings();
    progress.set_length((SCENES.len() + cost::STEPS) as u64);

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
    let display = tone_map.display(&frame);
    let reference = display.to_rgb8();
    let itself = Setting {
        name: REFERENCE,
        bytes_per_pixel: 8.0,
        fetches: 1.0,
        picture: Picture::Display(Frame::clone),
    };
    let mut rows = vec![row(scene.name, &itself, &reference, &reference)?];
    let mut cameras = Vec::new();
    for setting in settings {
        match setting.picture {
            Picture::Camera(quality) => cameras.push((setting, quality)),
            Picture::Display(store) => {
                let picture = store(&display).to_rgb8();
                rows.push(row(scene.name, setting, &reference, &picture)?);
            }
        }
    }
    let qualities: Vec<_> = cameras.iter().map(|(_, quality)| *quality).collect();
    let (bevy, pictures) = display_frames(scene, size, &qualities)?;
    for ((setting, _), picture) in cameras.iter().zip(&pictures) {
        rows.push(row(scene.name, setting, &bevy, picture)?);
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

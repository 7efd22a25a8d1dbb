//! The study of `bevy_ewa`: every method against the truth and against exact EWA, on scenes that
//! are hard in different ways.
//!
//! Pictures are rendered by the plugin's shaders at given coordinates, so that they are filtered
//! and nothing else. `truth` is the mean of at least 64 x 64 points a pixel, weighted by the kernel,
//! and `ewa` the method `reference` in 64-bit floats; both are computed. `fetches` are those of the
//! reference in plain Rust, in which a trilinear fetch counts as one. The picture of a temporal setting is the mean of its two frames.
//!
//! The rows `spatial, threshold N` are the spatial method's with other thresholds, computed; with
//! `16x sampler`, a probe counts as the one fetch that it is there.
//!
//! The rows `flicker, ...` have a mean squared error and nothing else: the mean squared change of
//! the error from a frame to the next, with a moving camera, a still one, and a still one under
//! temporal anti-aliasing that is modelled. In the scene `rasterised floor` it is Bevy's own, and the
//! error of a moving camera that against the method `reference` in the same frame.
//!
//! | module | gives |
//! | --- | --- |
//! | [`mod@settings`] | what is measured, by name |
//! | [`mod@flicker`] | what moves that should not |
//! | [`mod@summary`] | what a user chooses between |
//! | [`taa`] | the same with Bevy's temporal anti-aliasing, rasterised |
//! | [`thresholds`] | what the threshold of the spatial method trades |

pub mod flicker;
pub mod settings;
pub mod summary;
pub mod taa;
pub mod thresholds;

use bevy_ewa::{EwaMethod, EwaSettings};
use indicatif::ProgressBar;

use self::settings::{SETTINGS, Setting};
use super::{
    interleaved::{Candidate, benchmark_apps},
    plan::Plan,
    study::{Study, TradeoffError, note},
};
use crate::record::{Measurement, Report, ReportAdapter};
use bevy_frugal_lab::{
    lookups::{
        Lookups, TexelFormat,
        picture::{Pixels, computed_picture, display, mean, true_picture},
        scenes::{EwaScene, SCENES},
    },
    metrics::compare,
};

pub const STUDY: Study = Study {
    name: "ewa",
    measure,
    summary: summary::summary,
    tables: |_| String::new(),
};

/// Points of the truth along a side of a pixel.
const RATE: u32 = 64;

fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
    let Some(picture) = plan.picture else {
        return Ok(Report::default());
    };
    // Square; a sixth of the photographs' width, since the truth takes its time.
    let size = picture[0] / 6;
    progress.set_length(SCENES.len() as u64 + 4);
    let mut report = Report::default();
    for scene in &SCENES {
        progress.set_message(scene.name);
        report.measurements.extend(scene_rows(scene, size, RATE)?);
        progress.inc(1);
    }
    progress.set_message("thresholds");
    for scene in &SCENES {
        let rows = thresholds::threshold_rows(scene, size)?;
        report.measurements.extend(rows);
    }
    progress.inc(1);
    progress.set_message("flicker");
    for scene in SCENES
        .iter()
        .filter(|scene| ["tunnel", "floor"].contains(&scene.name))
    {
        report.measurements.extend(flicker_rows(scene, size));
    }
    progress.inc(1);
    progress.set_message("flicker under TAA");
    report.measurements.extend(taa_rows(size)?);
    progress.inc(1);
    progress.set_message("time");
    // Small ellipses and long ones.
    for scene in SCENES
        .iter()
        .filter(|scene| ["tunnel", "checker_5deg"].contains(&scene.name))
    {
        let size = plan.picture.map_or(64, |[width, _]| width / 4);
        let (adapter, rows) = time_rows(scene, size, plan, progress)?;
        report.adapter = adapter;
        report.measurements.extend(rows);
    }
    progress.inc(1);
    Ok(report)
}

/// The rows of a scene: every setting against both references.
pub fn scene_rows(
    scene: &EwaScene,
    size: u32,
    rate: u32,
) -> Result<Vec<Measurement>, TradeoffError> {
    let texture = (scene.texture)();
    let coordinates = scene.coordinates(size);
    let exact = EwaSettings::with_method(EwaMethod::Reference);
    let references = [
        (
            "truth",
            true_picture(&texture, &(scene.surface)(), size, rate),
        ),
        (
            "ewa",
            computed_picture(&texture, &coordinates, size, &exact, 0).0,
        ),
    ];
    let mut rows = Vec::new();
    for anisotropy in [1, 16] {
        let mut lookups = Lookups::new(
            size,
            &texture,
            TexelFormat::Float32,
            anisotropy,
            &coordinates,
        )?;
        if anisotropy > 1 && lookups.is_software() {
            continue;
        }
        for setting in SETTINGS
            .iter()
            .filter(|s| s.sampler_anisotropy == anisotropy)
        {
            let settings = setting.settings(anisotropy);
            let mut pictures = Vec::new();
            let mut fetches = 0.0;
            for frame in 0..setting.frames {
                let rendered = lookups.picture(&settings, frame)?;
                pictures.push(
                    rendered
                        .iter()
                        .map(|p| [p[0], p[1], p[2]].map(f64::from))
                        .collect(),
                );
                let counted =
                    computed_picture(&texture, &coordinates, size, &setting.settings(1), frame).1;
                fetches += counted / f64::from(setting.frames);
            }
            let picture = mean(&pictures);
            for (name, reference) in &references {
                rows.push(row(
                    scene, setting, name, reference, &picture, size, fetches,
                )?);
            }
        }
    }
    Ok(rows)
}

fn row(
    scene: &EwaScene,
    setting: &Setting,
    name: &str,
    reference: &Pixels,
    picture: &Pixels,
    size: u32,
    fetches: f64,
) -> Result<Measurement, TradeoffError> {
    let error = compare(&display(reference, size), &display(picture, size))?;
    Ok(Measurement {
        scene: scene.name.into(),
        setting: setting.name.into(),
        reference: name.into(),
        fetches: Some(fetches),
        ..Measurement::from(&error)
    })
}

pub fn flicker_rows(scene: &EwaScene, size: u32) -> Vec<Measurement> {
    let truths = flicker::truths(scene, size, RATE / 4);
    let mut rows = Vec::new();
    for setting in SETTINGS.iter().filter(|setting| !setting.needs_hardware()) {
        let settings = setting.settings(1);
        let found = flicker::flicker(scene, &truths, size, &settings, setting.frames);
        for (kind, mse) in [
            ("moving", found.moving),
            ("still", found.still),
            ("still, TAA", found.still_with_taa),
        ] {
            rows.push(Measurement {
                scene: scene.name.into(),
                setting: setting.name.into(),
                reference: format!("flicker, {kind}"),
                mse: Some(mse),
                ..Measurement::default()
            });
        }
    }
    rows
}

/// The rows of flicker with Bevy's temporal anti-aliasing and without it.
fn taa_rows(size: u32) -> Result<Vec<Measurement>, TradeoffError> {
    let mut rows = Vec::new();
    for (with, suffix) in [(false, ""), (true, ", Bevy's TAA")] {
        for found in taa::taa_flicker(size, with)? {
            for (kind, mse) in [("still", found.still), ("moving", found.moving)] {
                rows.push(Measurement {
                    scene: "rasterised floor".into(),
                    setting: found.setting.into(),
                    reference: format!("flicker, {kind}{suffix}"),
                    mse: Some(mse),
                    ..Measurement::default()
                });
            }
        }
    }
    Ok(rows)
}

/// Frame times of the settings, interleaved, of square pictures of `size` pixels, and what rendered them.
pub fn time_rows(
    scene: &EwaScene,
    size: u32,
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<(ReportAdapter, Vec<Measurement>), TradeoffError> {
    let texture = (scene.texture)();
    let coordinates = scene.coordinates(size);
    let mut candidates = Vec::new();
    let mut adapter = ReportAdapter::default();
    for setting in &SETTINGS {
        let lookups = |anisotropy| {
            let format = TexelFormat::Unorm8;
            Lookups::new(size, &texture, format, anisotropy, &coordinates)
        };
        let first = lookups(setting.sampler_anisotropy)?;
        let software = first.is_software();
        if software && setting.needs_hardware() {
            note(
                progress,
                "no texture unit here: `hardware_af16` is left out",
            );
            continue;
        }
        // Probes are the hardware's where there is one.
        let probes = if setting.has_probes() && !software {
            16
        } else {
            1
        };
        let mut lookups = if probes > 1 { lookups(probes)? } else { first };
        lookups.set(&setting.settings(probes), 0)?;
        adapter = lookups.app().adapter().into();
        let row = Measurement {
            scene: scene.name.into(),
            setting: setting.name.into(),
            reference: "time".into(),
            ..Measurement::default()
        };
        candidates.push(Candidate::new(lookups.into_app(), row));
    }
    Ok((
        adapter,
        benchmark_apps(candidates, plan.rounds, plan.frames)?,
    ))
}

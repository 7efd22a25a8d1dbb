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

use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings};
use bevy_frugal_lab::{
    lookups::{
        Lookups, TexelFormat,
        scenes::{EwaScene, SCENES, computed_picture, display, mean, true_picture},
    },
    metrics::{SizeMismatch, compare},
};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use crate::{
    benchmark,
    plan::Plan,
    record::{PictureRow, Report, ReportAdapter, TimeRow},
    run::{Study, TradeoffError, note},
    summary::{Choice, Need, Quantity, Source, Summary, means},
};

pub mod flicker;

/// The study.
pub struct Ewa;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    pub pictures: Vec<PictureRow>,
    pub flicker: Vec<FlickerRow>,
    pub times: Vec<TimeRow>,
}

/// The mean squared change of the error of a picture from a frame to the next, in squares of 8-bit units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlickerRow {
    pub scene: String,
    pub setting: String,
    /// How the camera moves, and what is done against flicker.
    pub camera: String,
    pub mse: f64,
}

impl FlickerRow {
    fn new(scene: &str, setting: &str, camera: impl Into<String>, mse: f64) -> Self {
        Self {
            scene: scene.into(),
            setting: setting.into(),
            camera: camera.into(),
            mse,
        }
    }
}

impl Study for Ewa {
    const NAME: &'static str = "ewa";
    type Rows = Rows;

    fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report<Rows>, TradeoffError> {
        let Some(picture) = plan.picture else {
            return Ok(Report::default());
        };
        // Square; a sixth of the photographs' width, since the truth takes its time.
        let size = picture[0] / 6;
        progress.set_length(SCENES.len() as u64 + 4);
        let mut report = Report::<Rows>::default();
        for scene in &SCENES {
            progress.set_message(scene.name);
            report.rows.pictures.extend(scene_rows(scene, size, RATE)?);
            progress.inc(1);
        }
        progress.set_message("thresholds");
        for scene in &SCENES {
            let rows = threshold_rows(scene, size)?;
            report.rows.pictures.extend(rows);
        }
        progress.inc(1);
        progress.set_message("flicker");
        for scene in SCENES
            .iter()
            .filter(|scene| ["tunnel", "floor"].contains(&scene.name))
        {
            report.rows.flicker.extend(flicker_rows(scene, size));
        }
        progress.inc(1);
        progress.set_message("flicker under TAA");
        report.rows.flicker.extend(taa_rows(size)?);
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
            report.rows.times.extend(rows);
        }
        progress.inc(1);
        Ok(report)
    }

    /// Mean squared error against exact EWA over all scenes, and time in the first.
    fn summary(rows: &Rows) -> Summary {
        let is_scene = |name: &str| SCENES.iter().any(|scene| scene.name == name);
        let errors =
            { rows.pictures.iter() }.filter(|row| row.reference == "ewa" && is_scene(&row.scene));
        let errors = means(errors.map(|row| (&row.setting, Some(row.error.mse))));
        let times = rows
            .times
            .iter()
            .map(|row| (&row.setting, row.times.frame_ms()));
        let times = means(times);
        let unit = UNITS.iter().find(|(name, _)| times.contains_key(*name));
        let (unit, unit_name) = *unit.unwrap_or(&UNITS[0]);
        let unit = times.get(unit);
        let measured = errors.iter().filter_map(|(name, error)| {
            let is_bevys = ["trilinear", "hardware_af16"].contains(name);
            Some(Choice {
                name: name.to_string(),
                error: *error,
                cost: times.get(name)? / unit?,
                source: if is_bevys {
                    Source::Baseline
                } else {
                    Source::Ours
                },
            })
        });
        let published = THESIS.map(|(name, error, speed)| Choice {
            name: format!("thesis: {name}"),
            error,
            cost: 1.0 / speed,
            source: Source::Published,
        });
        Summary {
            title: "bevy_ewa: error against time".into(),
            error: Quantity::less("mean squared error against exact EWA", "", 2)
                .logarithmic_from(1e-3),
            cost: Quantity::less("time", unit_name, 2).logarithmic_from(1e-3),
            choices: measured.chain(published).collect(),
            needs: vec![
                Need::LeastError,
                Need::Error(1.0),
                Need::Error(30.0),
                Need::LeastCost,
            ],
        }
    }
}

/// Points of the truth along a side of a pixel.
const RATE: u32 = 64;

/// The rows of a scene: every setting against both references.
pub fn scene_rows(
    scene: &EwaScene,
    size: u32,
    rate: u32,
) -> Result<Vec<PictureRow>, TradeoffError> {
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
                let error = compare(&display(reference, size), &display(&picture, size))?;
                rows.push(PictureRow {
                    scene: scene.name.into(),
                    setting: setting.name.into(),
                    reference: (*name).into(),
                    error: error.into(),
                    fetches,
                    ..PictureRow::default()
                });
            }
        }
    }
    Ok(rows)
}

pub fn flicker_rows(scene: &EwaScene, size: u32) -> Vec<FlickerRow> {
    let truths = flicker::truths(scene, size, RATE / 4);
    let computed = SETTINGS.iter().filter(|setting| !setting.needs_hardware());
    let rows = computed.flat_map(|setting| {
        let settings = setting.settings(1);
        let found = flicker::flicker(scene, &truths, size, &settings, setting.frames);
        found.map(|(camera, mse)| FlickerRow::new(scene.name, setting.name, camera, mse))
    });
    rows.collect()
}

/// The rows of flicker with Bevy's temporal anti-aliasing and without it.
fn taa_rows(size: u32) -> Result<Vec<FlickerRow>, TradeoffError> {
    let mut rows = Vec::new();
    for (with, suffix) in [(false, ""), (true, ", Bevy's TAA")] {
        for (setting, changes) in flicker::taa_flicker(size, with)? {
            rows.extend(changes.map(|(kind, mse)| {
                FlickerRow::new("rasterised floor", setting, format!("{kind}{suffix}"), mse)
            }));
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
) -> Result<(ReportAdapter, Vec<TimeRow>), TradeoffError> {
    let texture = (scene.texture)();
    let coordinates = scene.coordinates(size);
    let mut candidates = Vec::new();
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
        let row = TimeRow::new(scene.name, setting.name);
        candidates.push((lookups.into_app(), row));
    }
    Ok(benchmark::time_rows(
        candidates,
        plan.rounds,
        plan.frames,
        None,
    )?)
}

/// A method with its defaults.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name in the report.
    pub name: &'static str,
    pub method: EwaMethod,
    pub sampler_anisotropy: u16,
    pub frames: u32,
}

/// The settings; the hardware's are left out where there is no hardware.
pub const SETTINGS: [Setting; 11] = [
    setting("reference", EwaMethod::Reference, 1, 1),
    setting("linear", EwaMethod::Linear, 1, 1),
    setting("bilinear", EwaMethod::Bilinear, 1, 1),
    setting("approximate", EwaMethod::Approximate { probes: FIVE }, 1, 1),
    setting("spatial", EwaMethod::Spatial { probes: FIVE }, 1, 1),
    setting("temporal", EwaMethod::Temporal { probes: FIVE }, 1, 2),
    setting(
        "spatial_temporal",
        EwaMethod::SpatialTemporal { probes: FIVE },
        1,
        2,
    ),
    setting("stochastic", EwaMethod::Stochastic, 1, 16),
    setting("software_af16", EwaMethod::SoftwareAnisotropic, 1, 1),
    setting("hardware_af16", EwaMethod::Hardware, 16, 1),
    setting("trilinear", EwaMethod::Hardware, 1, 1),
];

const FIVE: EwaProbes = EwaProbes::Five;

const fn setting(
    name: &'static str,
    method: EwaMethod,
    sampler_anisotropy: u16,
    frames: u32,
) -> Setting {
    Setting {
        name,
        method,
        sampler_anisotropy,
        frames,
    }
}

impl Setting {
    /// The settings of the plugin. Where samplers have anisotropy, probes are the hardware's.
    pub fn settings(&self, probe_anisotropy: u16) -> EwaSettings {
        EwaSettings {
            sampler_anisotropy: self.sampler_anisotropy.max(probe_anisotropy),
            ..EwaSettings::with_method(self.method)
        }
    }

    /// Whether a setting needs a texture unit's own anisotropic filter.
    pub fn needs_hardware(&self) -> bool {
        self.sampler_anisotropy > 1
    }

    pub fn has_probes(&self) -> bool {
        matches!(
            self.method,
            EwaMethod::Approximate { .. }
                | EwaMethod::Spatial { .. }
                | EwaMethod::Temporal { .. }
                | EwaMethod::SpatialTemporal { .. }
        )
    }
}

/// The thesis's methods on a GTX 460 (Table 5.1): mean squared error against its reference, and
/// speed as a share of that of the texture unit's own filter.
const THESIS: [(&str, f64, f64); 6] = [
    ("reference", 0.0, 0.055),
    ("linear", 0.007, 0.074),
    ("bilinear", 6.4, 0.088),
    ("approximate", 30.0, 0.387),
    ("spatial", 55.0, 0.455),
    ("texture unit", 126.0, 1.0),
];
/// What times are compared with: the texture unit's own filter, or a model of it in the shader where the
/// driver has none.
const UNITS: [(&str, &str); 2] = [
    ("hardware_af16", "of 16x anisotropy"),
    ("software_af16", "of 16x anisotropy in a shader"),
];

/// The thresholds, from nearly always to never.
const THRESHOLDS: [u16; 7] = [2, 4, 8, 12, 16, 24, 32];

/// The points of the curve, on samplers without anisotropy, whose probes are computed, and on those
/// with it, where a probe is one fetch. The error is against `ewa`; all of it is computed.
fn threshold_rows(scene: &EwaScene, size: u32) -> Result<Vec<PictureRow>, SizeMismatch> {
    let texture = (scene.texture)();
    let coordinates = scene.coordinates(size);
    let picture = |settings: &EwaSettings| {
        let (pixels, fetches) = computed_picture(&texture, &coordinates, size, settings, 0);
        (display(&pixels, size), fetches)
    };
    let (reference, _) = picture(&EwaSettings::with_method(EwaMethod::Reference));
    let probes = EwaProbes::default();
    let mut rows = Vec::new();
    for (sampler_anisotropy, note) in [(1, ""), (16, ", 16x sampler")] {
        for threshold in THRESHOLDS {
            let (found, fetches) = picture(&EwaSettings {
                spatial_threshold: f32::from(threshold),
                sampler_anisotropy,
                ..EwaSettings::with_method(EwaMethod::Spatial { probes })
            });
            rows.push(PictureRow {
                scene: scene.name.into(),
                setting: format!("spatial, threshold {threshold}{note}"),
                reference: "ewa".into(),
                error: compare(&reference, &found)?.into(),
                fetches,
                ..PictureRow::default()
            });
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{PictureError, Times};

    #[test]
    fn times_are_those_of_the_texture_unit_or_of_its_model() {
        let picture = |reference: &str, mse| PictureRow {
            scene: SCENES[0].name.into(),
            setting: "linear".into(),
            reference: reference.into(),
            error: PictureError {
                mse,
                ..PictureError::default()
            },
            ..PictureRow::default()
        };
        let time = |setting: &str, gpu_ms| TimeRow {
            setting: setting.into(),
            times: Times {
                gpu_ms: Some(gpu_ms),
                ..Times::default()
            },
            ..TimeRow::default()
        };
        let mut rows = Rows {
            pictures: vec![picture("ewa", 0.5), picture("truth", 9.0)],
            times: vec![time("linear", 6.0), time("software_af16", 3.0)],
            ..Rows::default()
        };
        let cost = |rows: &Rows| {
            let found = Ewa::summary(rows);
            let linear = found.choices.iter().find(|c| c.name == "linear");
            linear.map(|c| (c.error, c.cost))
        };
        assert_eq!(cost(&rows), Some((0.5, 2.0)));
        rows.times.push(time("hardware_af16", 1.0));
        assert_eq!(cost(&rows), Some((0.5, 6.0)));
    }
}

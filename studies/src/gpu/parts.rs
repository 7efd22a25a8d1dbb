//! What is measured, part by part.

use indicatif::ProgressBar;

use super::{gi, options::Options};
use crate::{
    ewa,
    plan::Plan,
    record::{Measurement, ReportAdapter},
    study::TradeoffError,
    wavelet_tex::tunnel,
    ycocg_fb::{cameras::all_cameras, cost},
};
use bevy_frugal_lab::{content, lookups::scenes::SCENES};

/// Scenes of the lookups: small ellipses, and long ones.
pub const LOOKUP_SCENES: [&str; 2] = ["tunnel", "checker_5deg"];
const SEED: u64 = 5;

/// A part of the study. Each of its steps is measured by itself.
pub struct Part {
    /// The plugin of its rows.
    pub plugin: &'static str,
    steps: fn(&Options) -> Vec<u32>,
    rows: fn(&Options, u32, &Plan, &ProgressBar) -> Rows,
}

type Rows = Result<(ReportAdapter, Vec<Measurement>), TradeoffError>;

/// All parts, the quickest first.
pub const PARTS: [(&str, Part); 4] = [
    (
        "filters of wavelet textures",
        Part {
            plugin: "wavelet_tex",
            steps: |_| vec![0],
            rows: |options, _, plan, progress| {
                let picture = content::bricks(plan.tile[0], plan.tile[1], SEED).color;
                tunnel::rows(&picture, &tunnel::FILTERS, options.size.0, plan, progress)
            },
        },
    ),
    (
        "elliptical filters",
        Part {
            plugin: "ewa",
            steps: |_| (0..LOOKUP_SCENES.len() as u32).collect(),
            rows: |options, step, plan, progress| {
                let name = LOOKUP_SCENES[step as usize];
                let scene = SCENES.iter().find(|scene| scene.name == name);
                let scene = scene.unwrap_or(&SCENES[0]);
                // A square of as many pixels.
                let [width, height] = options.size.0.map(f64::from);
                let size = (width * height).sqrt().round() as u32;
                ewa::time_rows(scene, size, plan, progress)
            },
        },
    ),
    (
        "fill rate",
        Part {
            plugin: "ycocg_fb",
            steps: |_| (0..cost::STEPS as u32).collect(),
            rows: |options, step, plan, _| {
                let load = cost::loads(options.layers)[step as usize];
                cost::load_rows(load, &all_cameras(), options.size.0, plan)
            },
        },
    ),
    (
        "global illumination",
        Part {
            plugin: "voxel_gi",
            steps: |options| options.resolutions.clone(),
            rows: |options, resolution, plan, _| gi::rows(resolution, options.size.0, plan),
        },
    ),
];

impl Part {
    /// What its steps are called.
    pub fn steps(&self, options: &Options) -> Vec<u32> {
        (self.steps)(options)
    }

    /// The rows of a step.
    ///
    /// # Errors
    /// [`TradeoffError`] where nothing can be rendered.
    pub fn rows(&self, options: &Options, step: u32, progress: &ProgressBar) -> Rows {
        let plan = Plan {
            rounds: options.rounds,
            frames: options.frames,
            tunnel_frames: options.frames,
            ..Plan::new(true)
        };
        (self.rows)(options, step, &plan, progress)
    }
}

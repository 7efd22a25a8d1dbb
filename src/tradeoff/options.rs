//! The command line, and how much of a study it asks for.

use std::path::{Path, PathBuf};

use clap::{Parser, builder::PossibleValuesParser};

use super::{STUDIES, Study};
use crate::boxes::TracedScene;

/// Stands for every study on the command line.
const ALL: &str = "all";

/// Measures what a plugin costs and what it gains: accuracy, memory and time.
#[derive(Clone, Debug, Parser)]
#[command(name = "tradeoff")]
pub struct Options {
    /// Plugin to measure.
    #[arg(value_name = "PLUGIN", value_parser = PossibleValuesParser::new(names()))]
    pub plugin: String,
    /// Fewer images, smaller pictures and fewer repetitions.
    #[arg(long)]
    pub quick: bool,
    /// Leaves out volumes of more voxels along an edge: 64 take an hour on a software driver.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..))]
    pub max_resolution: Option<u32>,
    /// Folder of the reports, made where it is missing.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff")]
    pub out: PathBuf,
    /// Measures nothing: reads the reports of an earlier run from this folder.
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Document in which to renew the tables of advice, between `<!-- tradeoff PLUGIN -->` and
    /// `<!-- end -->`.
    #[arg(long, value_name = "FILE")]
    pub advise: Option<PathBuf>,
}

impl Options {
    /// The studies that were asked for.
    pub fn studies(&self) -> impl Iterator<Item = &'static Study> {
        STUDIES
            .iter()
            .filter(|study| self.plugin == ALL || self.plugin == study.name)
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    STUDIES.iter().map(|study| study.name).chain([ALL])
}

/// How much a study measures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Width and height of the photograph, in pixels.
    pub photo: [u32; 2],
    /// Width and height of the tiling materials, in pixels.
    pub tile: [u32; 2],
    /// Folder of the Kodak images, `kodimNN.png`; left out with a note where it is missing.
    pub kodak_folder: PathBuf,
    /// Numbers of the Kodak images that become textures.
    pub kodak: Vec<u32>,
    /// Whether they are encoded with every effort, and in gray, too.
    pub kodak_in_full: bool,
    /// Numbers of those that become frames.
    pub photographs: Vec<u32>,
    /// How often a time on the CPU is taken, for its median; at least 1.
    pub repetitions: usize,
    /// Width and height of the rendered picture, in pixels; none renders nothing.
    pub picture: Option<[u32; 2]>,
    /// Width and height of the frames that a frame buffer stores, in pixels; none renders nothing.
    pub frame: Option<[u32; 2]>,
    /// Rounds in which the settings take turns, for the median of their frame times.
    pub rounds: u32,
    /// Frames of a setting in a round.
    pub frames: u32,
    /// The same of the tunnel of wavelet textures, which has many settings.
    pub tunnel_frames: u32,
    /// What the study of global illumination measures.
    pub gi: GiPlan,
}

/// What the study of global illumination measures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GiPlan {
    /// Names of the path-traced scenes.
    pub scenes: Vec<&'static str>,
    /// Voxels along an edge, at least one.
    pub resolutions: Vec<u32>,
    /// Rays from each side of a voxel, with each resolution.
    pub rays: Vec<u32>,
    /// Steps of propagated light, with each resolution.
    pub iterations: Vec<u32>,
    /// Bounces in each frame.
    pub bounces: Vec<u32>,
    /// Voxelisers, shadow samples and ambient occlusion too.
    pub variants: bool,
    /// Numbers of triangles, about.
    pub triangles: Vec<u32>,
    /// Rounds in which the settings take turns.
    pub rounds: u32,
    /// Frames of a setting in a round.
    pub frames: u32,
}

impl GiPlan {
    fn new(quick: bool) -> Self {
        let scenes = TracedScene::NAMES.into();
        if quick {
            Self {
                scenes,
                resolutions: vec![16],
                rays: vec![8],
                iterations: Vec::new(),
                bounces: vec![1],
                variants: false,
                triangles: vec![1_000, 10_000],
                rounds: 3,
                frames: 2,
            }
        } else {
            Self {
                scenes,
                resolutions: vec![16, 32, 64],
                rays: vec![8, 16, 32, 64],
                iterations: vec![32, 96, 256],
                bounces: vec![1, 2, 4],
                variants: true,
                triangles: vec![1_000, 10_000, 100_000, 1_000_000],
                rounds: 5,
                frames: 5,
            }
        }
    }
}

impl Plan {
    /// All that there is to measure, or the part that takes a minute or two.
    pub fn new(quick: bool) -> Self {
        let (photographs, repetitions, picture, rounds, frames) = if quick {
            (vec![5, 13, 23], 1, [256, 170], 5, 9)
        } else {
            ((1..=24).collect(), 3, [768, 512], 9, 15)
        };
        Self {
            photo: [768, 512],
            tile: [512; 2],
            kodak_folder: Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/kodak"),
            kodak: (1..=24).collect(),
            kodak_in_full: !quick,
            photographs,
            repetitions,
            picture: Some(picture),
            frame: Some(if quick { [640, 360] } else { [1280, 720] }),
            rounds,
            frames,
            tunnel_frames: if quick { 2 } else { 5 },
            gi: GiPlan::new(quick),
        }
    }

    /// The plan of a command line.
    pub fn of(options: &Options) -> Self {
        let mut plan = Self::new(options.quick);
        if let Some(most) = options.max_resolution {
            plan.gi.resolutions.retain(|resolution| *resolution <= most);
        }
        plan
    }
}

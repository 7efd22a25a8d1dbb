//! How much a study measures.

use std::path::{Path, PathBuf};

use bevy_frugal_lab::{
    ROOT,
    boxes::TracedScene,
    meshes::{arcade::ArcadeSettings, town::TownCamera},
};

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
    /// How often a time on the CPU is taken, for its median; at least 1.
    pub repetitions: usize,
    /// Width and height of the rendered picture, in pixels; none renders nothing.
    pub picture: Option<[u32; 2]>,
    /// Width and height of the frames that a frame buffer stores, in pixels; none renders nothing.
    pub frame: Option<[u32; 2]>,
    /// Rounds of the interleaved benchmark, over which the frame times of a setting have their median.
    pub rounds: u32,
    /// Frames of a setting in a round.
    pub frames: u32,
    /// The same of the tunnel of wavelet textures, which has many settings.
    pub tunnel_frames: u32,
    pub gi: GiPlan,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GiPlan {
    pub scenes: Vec<&'static str>,
    /// Names of the settings; none stands for all.
    pub settings: Vec<String>,
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
    /// The arcade; none leaves it out.
    pub arcade: Option<ArcadePlan>,
    /// The town.
    pub town: TownPlan,
    /// Numbers of triangles, about.
    pub triangles: Vec<u32>,
    /// Rounds of the interleaved benchmark.
    pub rounds: u32,
    /// Frames of a setting in a round.
    pub frames: u32,
}

/// How the arcade is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArcadePlan {
    /// How detailed it is.
    pub scene: ArcadeSettings,
    /// Paths from each pixel of its truth.
    pub samples: u32,
}

/// How the town is measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TownPlan {
    /// From where; nothing is measured without.
    pub cameras: Vec<TownCamera>,
    /// Voxels along an edge of a volume.
    pub resolution: u32,
    /// Width and height of the picture in pixels.
    pub picture: u32,
    /// Paths from each pixel of its truth.
    pub samples: u32,
}

/// The name of the arcade on the command line.
const ARCADE: &str = "arcade";
/// The scenes of global illumination; the town is one from each camera.
pub const GI_SCENES: [&str; 9] = {
    let [a, b, c] = TracedScene::NAMES;
    let [d, e, f, g, h] = TownCamera::ALL;
    [
        a,
        b,
        c,
        ARCADE,
        d.name(),
        e.name(),
        f.name(),
        g.name(),
        h.name(),
    ]
};

impl GiPlan {
    /// Leaves out all scenes but these, and the numbers of triangles.
    pub fn retain_scenes(&mut self, names: &[String]) {
        let is_named = |scene: &str| names.iter().any(|name| name == scene);
        self.scenes.retain(|scene| is_named(scene));
        if !is_named(ARCADE) {
            self.arcade = None;
        }
        let cameras = TownCamera::ALL.into_iter();
        self.town.cameras = cameras.filter(|camera| is_named(camera.name())).collect();
        self.triangles.clear();
    }

    /// Leaves out all settings but these, and the numbers of triangles.
    pub fn retain_settings(&mut self, names: &[String]) {
        self.settings = names.into();
        self.triangles.clear();
    }

    fn new(quick: bool) -> Self {
        let scenes = TracedScene::NAMES.into();
        if quick {
            Self {
                scenes,
                settings: Vec::new(),
                resolutions: vec![16],
                rays: vec![8],
                iterations: Vec::new(),
                bounces: vec![1],
                variants: false,
                arcade: Some(ArcadePlan {
                    scene: ArcadeSettings {
                        statue_triangles: 50_000,
                        picture: 64,
                    },
                    samples: 1024,
                }),
                // Each camera takes a minute or more, so only those that are named.
                town: TownPlan {
                    cameras: Vec::new(),
                    resolution: 32,
                    picture: 64,
                    samples: 1024,
                },
                triangles: vec![1_000, 10_000],
                rounds: 3,
                frames: 2,
            }
        } else {
            Self {
                scenes,
                settings: Vec::new(),
                resolutions: vec![16, 32, 64, 128],
                rays: vec![8, 16, 32, 64],
                iterations: vec![32, 96, 256],
                bounces: vec![1, 2, 4],
                variants: true,
                arcade: Some(ArcadePlan {
                    scene: ArcadeSettings::default(),
                    samples: 1024,
                }),
                town: TownPlan {
                    cameras: TownCamera::ALL.into(),
                    resolution: 32,
                    picture: 128,
                    samples: 1024,
                },
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
        let (repetitions, picture, rounds, frames) = if quick {
            (1, [256, 170], 5, 9)
        } else {
            (3, [768, 512], 9, 15)
        };
        Self {
            photo: [768, 512],
            tile: [512; 2],
            kodak_folder: Path::new(ROOT).join("../shared/data/kodak"),
            kodak: (1..=24).collect(),
            kodak_in_full: !quick,
            repetitions,
            picture: Some(picture),
            frame: Some(if quick { [640, 360] } else { [1280, 720] }),
            rounds,
            frames,
            tunnel_frames: if quick { 2 } else { 5 },
            gi: GiPlan::new(quick),
        }
    }
}

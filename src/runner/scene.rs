//! The trait of a scene, and the command line that runs one.

use std::{collections::BTreeMap, path::PathBuf, str::FromStr};

use bevy::{camera::visibility::RenderLayers, prelude::*};
use clap::{ArgMatches, Args, Command, FromArgMatches};

use crate::{
    headless::adapter::is_software,
    runner::{SceneSetting, SceneSettings, SettingError},
};

/// Render layer of what only the "before" camera sees. Layer 0 is seen by both.
pub const BEFORE_LAYER: usize = 1;
/// Render layer of what only the "after" camera sees. Layer 0 is seen by both.
pub const AFTER_LAYER: usize = 2;

#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Without the plugin: left of the line.
    Before,
    After,
}

impl Side {
    /// Both sides, from left to right.
    pub const BOTH: [Self; 2] = [Self::Before, Self::After];

    /// The layers for an entity that only this side's camera sees.
    pub fn layers(self) -> RenderLayers {
        RenderLayers::layer(match self {
            Self::Before => BEFORE_LAYER,
            Self::After => AFTER_LAYER,
        })
    }
}

/// An example scene of a plugin.
///
/// A scene is stateless; its state lives in the world that [`build`](Self::build) fills.
pub trait Scene: Sync {
    /// Name in file names and on the command line, in `snake_case`.
    fn name(&self) -> &'static str;

    /// Crate name of the plugin that it shows.
    fn plugin(&self) -> &'static str;

    /// What there is to see, in a sentence.
    fn description(&self) -> &'static str;

    /// The values to play with, in the order of the panel. Default none.
    fn settings(&self) -> Vec<SceneSetting> {
        Vec::new()
    }

    fn view(&self) -> Transform;

    /// Adds the plugin and the systems that spawn the scene.
    ///
    /// Everything but cameras: those are spawned by the runner. The resources `SceneSettings`,
    /// [`SceneImage`], [`MemoryFigures`], [`Notes`] and `AwaitedAssets` are in the world already.
    fn build(&self, app: &mut App);

    /// Adds components to a camera of the runner. Default: nothing.
    fn configure_camera(&self, camera: &mut EntityCommands, side: Side) {
        let _ = (camera, side);
    }
}

/// The image that the user chose with `--image`, for scenes that show one.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneImage(pub Option<PathBuf>);

/// What the plugin occupies on the GPU, filled by the scene: a name and a number of bytes.
///
/// Names that end in ` before` and ` after` stand beside each other in the panel.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryFigures(pub BTreeMap<String, u64>);

/// What a scene has to say about itself as it runs: a name and a text.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes(pub BTreeMap<String, String>);

/// Size of a picture in pixels, written `640x360`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let side = |text: &str| text.parse().ok().filter(|side| *side > 0);
        text.split_once('x')
            .and_then(|(width, height)| {
                let (width, height) = (side(width)?, side(height)?);
                Some(Self { width, height })
            })
            .ok_or_else(|| format!("`{text}` is no size: write WIDTHxHEIGHT, such as 640x360"))
    }
}

/// What the user asks for.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Open no window; write pictures and figures into this folder.
    #[arg(long, value_name = "DIR")]
    pub headless: Option<PathBuf>,
    /// Size of the picture, or of the window, in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: Size,
    /// Frames to measure on each side (headless), 1 or more.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Changes a setting of the scene; may be given several times.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Headless: only one picture, NAME.jpg, before at the left of a line and after at the right.
    #[arg(long, requires = "headless")]
    pub split: bool,
    /// An image to show instead of the built-in one, where the scene shows one.
    #[arg(long, value_name = "FILE")]
    pub image: Option<PathBuf>,
    /// Part of the name of the graphics adapter.
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

impl Options {
    /// One frame of a picture of this size, with these settings.
    pub fn picture(width: u32, height: u32, set: &[&str]) -> Self {
        Self {
            headless: None,
            size: Size { width, height },
            frames: 1,
            set: set.iter().map(ToString::to_string).collect(),
            split: false,
            image: None,
            adapter: None,
        }
    }

    /// The command with these options; pictures that the CPU draws are small unless asked otherwise.
    pub fn added_to(command: Command) -> Command {
        let command = Self::augment_args(command);
        if !is_software(None) {
            return command;
        }
        command
            .mut_arg("size", |size| size.default_value("480x270"))
            .mut_arg("frames", |frames| frames.default_value("1"))
    }

    /// The options of a parsed command line.
    pub fn from_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Self::from_arg_matches(matches)
    }

    /// The settings of `scene` with those of the command line.
    pub fn settings(&self, scene: &dyn Scene) -> Result<SceneSettings, SettingError> {
        let mut settings = SceneSettings::new(scene.settings());
        for text in &self.set {
            settings.set(text)?;
        }
        Ok(settings)
    }
}

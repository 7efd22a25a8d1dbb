//! The trait of a scene, the command line that runs one, and its settings with their values.

use std::{collections::BTreeMap, fmt, ops::RangeInclusive, path::PathBuf, str::FromStr};

use bevy::{camera::visibility::RenderLayers, ecs::resource::Resource, prelude::*};
use clap::{ArgMatches, Args, Command, FromArgMatches};
use thiserror::Error;

use crate::headless::is_software;

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

    pub fn name(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::After => "after",
        }
    }

    /// The layer that only this side's camera sees.
    pub fn layer(self) -> usize {
        match self {
            Self::Before => BEFORE_LAYER,
            Self::After => AFTER_LAYER,
        }
    }

    /// The layers for an entity that only this side's camera sees.
    pub fn layers(self) -> RenderLayers {
        RenderLayers::layer(self.layer())
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

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {} pixels", self.width, self.height)
    }
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

/// A setting that no setting takes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SettingError {
    /// The text has no `=`.
    #[error("`{text}` is not of the form name=value; the settings are:\n{settings}")]
    Form {
        text: String,
        /// The settings with their ranges, one a line.
        settings: String,
    },
    #[error("there is no setting `{name}`; the settings are:\n{settings}")]
    Unknown {
        name: String,
        /// The settings with their ranges, one a line.
        settings: String,
    },
    /// The setting does not take this value.
    #[error(
        "setting `{name}` cannot be `{value}`, it takes {range}; the settings are:\n{settings}"
    )]
    Value {
        name: String,
        value: String,
        range: String,
        /// The settings with their ranges, one a line.
        settings: String,
    },
}

/// All settings of a scene with their values. Scene systems see a change by change detection.
///
/// The typed getters panic for a name or kind that the scene did not declare: that is an error of
/// the scene, not of the user.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct SceneSettings(Vec<(SceneSetting, SettingValue)>);

impl SceneSettings {
    /// The settings at their defaults.
    pub fn new(settings: Vec<SceneSetting>) -> Self {
        let with_default = |setting: SceneSetting| {
            let value = setting.default_value();
            (setting, value)
        };
        Self(settings.into_iter().map(with_default).collect())
    }

    /// Applies `name=value`.
    pub fn set(&mut self, text: &str) -> Result<(), SettingError> {
        let settings = self.list();
        let Some((name, value)) = text.split_once('=') else {
            let text = text.into();
            return Err(SettingError::Form { text, settings });
        };
        let Some((setting, slot)) = self.0.iter_mut().find(|(setting, _)| setting.name == name)
        else {
            let name = name.into();
            return Err(SettingError::Unknown { name, settings });
        };
        *slot = setting.parse(value).ok_or_else(|| SettingError::Value {
            name: name.into(),
            value: value.into(),
            range: setting.range_text(),
            settings,
        })?;
        Ok(())
    }

    /// The settings with ranges, current values and help, one a line.
    pub fn list(&self) -> String {
        if self.0.is_empty() {
            return "  (none)".into();
        }
        let line = |(setting, value): &(SceneSetting, SettingValue)| {
            let range = setting.range_text();
            format!("  {}={value} ({range}): {}", setting.name, setting.help)
        };
        self.0.iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// SceneSettings and values, in the order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = (&SceneSetting, SettingValue)> {
        self.0.iter().map(|(setting, value)| (setting, *value))
    }

    /// SceneSettings and values to change; a value must keep its kind and range.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&SceneSetting, &mut SettingValue)> {
        self.0.iter_mut().map(|(setting, value)| (&*setting, value))
    }

    /// Value of the toggle `name`.
    pub fn toggle(&self, name: &str) -> bool {
        match self.value(name) {
            SettingValue::Toggle(value) => value,
            other => panic!("setting `{name}` is no toggle but {other:?}"),
        }
    }

    /// Value of the real number `name`.
    pub fn float(&self, name: &str) -> f32 {
        match self.value(name) {
            SettingValue::Float(value) => value,
            other => panic!("setting `{name}` is no float but {other:?}"),
        }
    }

    /// Value of the whole number `name`.
    pub fn integer(&self, name: &str) -> u32 {
        match self.value(name) {
            SettingValue::Integer(value) => value,
            other => panic!("setting `{name}` is no integer but {other:?}"),
        }
    }

    /// The chosen name of the choice `name`.
    pub fn choice(&self, name: &str) -> &'static str {
        match self.value(name) {
            SettingValue::Choice(value) => value,
            other => panic!("setting `{name}` is no choice but {other:?}"),
        }
    }

    fn value(&self, name: &str) -> SettingValue {
        match self.0.iter().find(|(setting, _)| setting.name == name) {
            Some((_, value)) => *value,
            None => panic!("the scene declares no setting `{name}`"),
        }
    }
}

/// Kind, range and default of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingKind {
    Toggle {
        default: bool,
    },
    /// A real number.
    Float {
        /// Value at the start, within the range.
        default: f32,
        range: RangeInclusive<f32>,
        /// Unit to show, empty for a pure number.
        unit: &'static str,
    },
    /// A whole number.
    Integer {
        /// Value at the start, within the range.
        default: u32,
        range: RangeInclusive<u32>,
        /// Unit to show, empty for a pure number.
        unit: &'static str,
    },
    Choice {
        /// Index of the name at the start.
        default: usize,
        names: &'static [&'static str],
    },
}

/// A value that the user may change.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSetting {
    /// Name in the panel and on the command line, in `snake_case`.
    pub name: &'static str,
    /// What it does, in a few words.
    pub help: &'static str,
    /// Kind, range and default.
    pub kind: SettingKind,
}

impl SceneSetting {
    /// A setting that is on or off.
    pub fn toggle(name: &'static str, help: &'static str, default: bool) -> Self {
        let kind = SettingKind::Toggle { default };
        Self { name, help, kind }
    }

    /// A setting for a real number in `unit`s.
    pub fn float(
        name: &'static str,
        help: &'static str,
        default: f32,
        range: RangeInclusive<f32>,
        unit: &'static str,
    ) -> Self {
        let kind = SettingKind::Float {
            default,
            range,
            unit,
        };
        Self { name, help, kind }
    }

    /// A setting for a whole number in `unit`s.
    pub fn integer(
        name: &'static str,
        help: &'static str,
        default: u32,
        range: RangeInclusive<u32>,
        unit: &'static str,
    ) -> Self {
        let kind = SettingKind::Integer {
            default,
            range,
            unit,
        };
        Self { name, help, kind }
    }

    /// A setting for one of several names; `default` is an index.
    pub fn choice(
        name: &'static str,
        help: &'static str,
        default: usize,
        names: &'static [&'static str],
    ) -> Self {
        let kind = SettingKind::Choice { default, names };
        Self { name, help, kind }
    }

    /// The allowed values as text, e.g. `0 to 1 m`.
    pub fn range_text(&self) -> String {
        let with_unit = |text: String, unit: &str| format!("{text} {unit}").trim_end().into();
        match &self.kind {
            SettingKind::Toggle { .. } => "true or false".into(),
            SettingKind::Float { range, unit, .. } => {
                with_unit(format!("{} to {}", range.start(), range.end()), unit)
            }
            SettingKind::Integer { range, unit, .. } => {
                with_unit(format!("{} to {}", range.start(), range.end()), unit)
            }
            SettingKind::Choice { names, .. } => names.join(", "),
        }
    }

    fn default_value(&self) -> SettingValue {
        match &self.kind {
            SettingKind::Toggle { default } => SettingValue::Toggle(*default),
            SettingKind::Float { default, .. } => SettingValue::Float(*default),
            SettingKind::Integer { default, .. } => SettingValue::Integer(*default),
            SettingKind::Choice { default, names } => SettingValue::Choice(names[*default]),
        }
    }

    fn parse(&self, text: &str) -> Option<SettingValue> {
        match &self.kind {
            SettingKind::Toggle { .. } => text.parse().ok().map(SettingValue::Toggle),
            SettingKind::Float { range, .. } => {
                let value = text.parse().ok()?;
                range.contains(&value).then_some(SettingValue::Float(value))
            }
            SettingKind::Integer { range, .. } => {
                let value = text.parse().ok()?;
                range
                    .contains(&value)
                    .then_some(SettingValue::Integer(value))
            }
            SettingKind::Choice { names, .. } => {
                let name = names.iter().find(|name| **name == text)?;
                Some(SettingValue::Choice(name))
            }
        }
    }
}

/// A setting for one of several values, each with its name.
pub struct Choice<T, const N: usize> {
    name: &'static str,
    help: &'static str,
    default: usize,
    names: [&'static str; N],
    values: [T; N],
}

impl<T: Copy, const N: usize> Choice<T, N> {
    /// `default` is an index.
    pub const fn new(
        name: &'static str,
        help: &'static str,
        default: usize,
        choices: [(&'static str, T); N],
    ) -> Self {
        let (mut names, mut values) = ([""; N], [choices[default].1; N]);
        let mut i = 0;
        while i < N {
            names[i] = choices[i].0;
            values[i] = choices[i].1;
            i += 1;
        }
        Self {
            name,
            help,
            default,
            names,
            values,
        }
    }

    pub fn setting(&'static self) -> SceneSetting {
        SceneSetting::choice(self.name, self.help, self.default, &self.names)
    }

    /// The chosen value.
    pub fn of(&self, settings: &SceneSettings) -> T {
        let chosen = settings.choice(self.name);
        let index = self.names.iter().position(|name| *name == chosen);
        self.values[index.unwrap_or(self.default)]
    }
}

/// The value of a setting, of its kind.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum SettingValue {
    Toggle(bool),
    /// A real number.
    Float(f32),
    /// A whole number.
    Integer(u32),
    Choice(&'static str),
}

impl fmt::Display for SettingValue {
    /// As it is written in `name=value`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Toggle(value) => value.fmt(f),
            Self::Float(value) => value.fmt(f),
            Self::Integer(value) => value.fmt(f),
            Self::Choice(value) => value.fmt(f),
        }
    }
}

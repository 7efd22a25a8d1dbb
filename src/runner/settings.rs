//! The settings of a scene with their values.

use std::{fmt, ops::RangeInclusive};

use bevy::ecs::resource::Resource;
use thiserror::Error;

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

    pub(super) fn default_value(&self) -> SettingValue {
        match &self.kind {
            SettingKind::Toggle { default } => SettingValue::Toggle(*default),
            SettingKind::Float { default, .. } => SettingValue::Float(*default),
            SettingKind::Integer { default, .. } => SettingValue::Integer(*default),
            SettingKind::Choice { default, names } => SettingValue::Choice(names[*default]),
        }
    }

    pub(super) fn parse(&self, text: &str) -> Option<SettingValue> {
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

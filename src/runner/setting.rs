//! A named value with a range: what a scene lets the user change.

use std::{fmt, ops::RangeInclusive};

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

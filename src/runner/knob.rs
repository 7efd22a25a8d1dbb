//! A named value with a range: what a scene lets the user change.

use std::{fmt, ops::RangeInclusive};

/// Kind, range and default of a knob.
#[derive(Clone, Debug, PartialEq)]
pub enum KnobKind {
    /// On or off.
    Toggle {
        /// Value at the start.
        default: bool,
    },
    /// A real number.
    Float {
        /// Value at the start, within the range.
        default: f32,
        /// Allowed values.
        range: RangeInclusive<f32>,
        /// Unit to show, empty for a pure number.
        unit: &'static str,
    },
    /// A whole number.
    Integer {
        /// Value at the start, within the range.
        default: u32,
        /// Allowed values.
        range: RangeInclusive<u32>,
        /// Unit to show, empty for a pure number.
        unit: &'static str,
    },
    /// One of several names.
    Choice {
        /// Index of the name at the start.
        default: usize,
        /// The names.
        names: &'static [&'static str],
    },
}

/// A value that the user may change.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Name in the panel and on the command line, in `snake_case`.
    pub name: &'static str,
    /// What it does, in a few words.
    pub help: &'static str,
    /// Kind, range and default.
    pub kind: KnobKind,
}

impl Knob {
    /// A knob that is on or off.
    pub fn toggle(name: &'static str, help: &'static str, default: bool) -> Self {
        let kind = KnobKind::Toggle { default };
        Self { name, help, kind }
    }

    /// A knob for a real number in `unit`s.
    pub fn float(
        name: &'static str,
        help: &'static str,
        default: f32,
        range: RangeInclusive<f32>,
        unit: &'static str,
    ) -> Self {
        let kind = KnobKind::Float {
            default,
            range,
            unit,
        };
        Self { name, help, kind }
    }

    /// A knob for a whole number in `unit`s.
    pub fn integer(
        name: &'static str,
        help: &'static str,
        default: u32,
        range: RangeInclusive<u32>,
        unit: &'static str,
    ) -> Self {
        let kind = KnobKind::Integer {
            default,
            range,
            unit,
        };
        Self { name, help, kind }
    }

    /// A knob for one of several names; `default` is an index.
    pub fn choice(
        name: &'static str,
        help: &'static str,
        default: usize,
        names: &'static [&'static str],
    ) -> Self {
        let kind = KnobKind::Choice { default, names };
        Self { name, help, kind }
    }

    /// The allowed values as text, e.g. `0 to 1 m`.
    pub fn range_text(&self) -> String {
        let with_unit = |text: String, unit: &str| format!("{text} {unit}").trim_end().into();
        match &self.kind {
            KnobKind::Toggle { .. } => "true or false".into(),
            KnobKind::Float { range, unit, .. } => {
                with_unit(format!("{} to {}", range.start(), range.end()), unit)
            }
            KnobKind::Integer { range, unit, .. } => {
                with_unit(format!("{} to {}", range.start(), range.end()), unit)
            }
            KnobKind::Choice { names, .. } => names.join(", "),
        }
    }

    pub(super) fn default_value(&self) -> KnobValue {
        match &self.kind {
            KnobKind::Toggle { default } => KnobValue::Toggle(*default),
            KnobKind::Float { default, .. } => KnobValue::Float(*default),
            KnobKind::Integer { default, .. } => KnobValue::Integer(*default),
            KnobKind::Choice { default, names } => KnobValue::Choice(names[*default]),
        }
    }

    pub(super) fn parse(&self, text: &str) -> Option<KnobValue> {
        match &self.kind {
            KnobKind::Toggle { .. } => text.parse().ok().map(KnobValue::Toggle),
            KnobKind::Float { range, .. } => {
                let value = text.parse().ok()?;
                range.contains(&value).then_some(KnobValue::Float(value))
            }
            KnobKind::Integer { range, .. } => {
                let value = text.parse().ok()?;
                range.contains(&value).then_some(KnobValue::Integer(value))
            }
            KnobKind::Choice { names, .. } => {
                let name = names.iter().find(|name| **name == text)?;
                Some(KnobValue::Choice(name))
            }
        }
    }
}

/// The value of a knob, of its kind.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum KnobValue {
    /// On or off.
    Toggle(bool),
    /// A real number.
    Float(f32),
    /// A whole number.
    Integer(u32),
    /// The chosen name.
    Choice(&'static str),
}

impl fmt::Display for KnobValue {
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

//! Named values with ranges: the knobs of a scene.

use std::{fmt, ops::RangeInclusive};

use bevy::ecs::resource::Resource;
use thiserror::Error;

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

    fn default_value(&self) -> KnobValue {
        match &self.kind {
            KnobKind::Toggle { default } => KnobValue::Toggle(*default),
            KnobKind::Float { default, .. } => KnobValue::Float(*default),
            KnobKind::Integer { default, .. } => KnobValue::Integer(*default),
            KnobKind::Choice { default, names } => KnobValue::Choice(names[*default]),
        }
    }

    fn parse(&self, text: &str) -> Option<KnobValue> {
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

/// A setting that no knob takes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum KnobError {
    /// The text has no `=`.
    #[error("`{text}` is not of the form name=value; the knobs are:\n{knobs}")]
    Form {
        /// What was given.
        text: String,
        /// The knobs with their ranges, one a line.
        knobs: String,
    },
    /// There is no such knob.
    #[error("there is no knob `{name}`; the knobs are:\n{knobs}")]
    Unknown {
        /// What was given.
        name: String,
        /// The knobs with their ranges, one a line.
        knobs: String,
    },
    /// The knob does not take this value.
    #[error("knob `{name}` cannot be `{value}`, it takes {range}; the knobs are:\n{knobs}")]
    Value {
        /// Name of the knob.
        name: String,
        /// What was given.
        value: String,
        /// What it takes.
        range: String,
        /// The knobs with their ranges, one a line.
        knobs: String,
    },
}

/// All knobs of a scene with their values. Scene systems see a change by change detection.
///
/// The typed getters panic for a name or kind that the scene did not declare: that is an error of
/// the scene, not of the user.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Knobs(Vec<(Knob, KnobValue)>);

impl Knobs {
    /// The knobs at their defaults.
    pub fn new(knobs: Vec<Knob>) -> Self {
        let with_default = |knob: Knob| {
            let value = knob.default_value();
            (knob, value)
        };
        Self(knobs.into_iter().map(with_default).collect())
    }

    /// Applies `name=value`.
    ///
    /// # Errors
    /// [`KnobError`], listing all knobs, when the name or the value does not fit.
    pub fn set(&mut self, text: &str) -> Result<(), KnobError> {
        let knobs = self.list();
        let Some((name, value)) = text.split_once('=') else {
            let text = text.into();
            return Err(KnobError::Form { text, knobs });
        };
        let Some((knob, slot)) = self.0.iter_mut().find(|(knob, _)| knob.name == name) else {
            let name = name.into();
            return Err(KnobError::Unknown { name, knobs });
        };
        *slot = knob.parse(value).ok_or_else(|| KnobError::Value {
            name: name.into(),
            value: value.into(),
            range: knob.range_text(),
            knobs,
        })?;
        Ok(())
    }

    /// The knobs with ranges, current values and help, one a line.
    pub fn list(&self) -> String {
        if self.0.is_empty() {
            return "  (none)".into();
        }
        let line = |(knob, value): &(Knob, KnobValue)| {
            let range = knob.range_text();
            format!("  {}={value} ({range}): {}", knob.name, knob.help)
        };
        self.0.iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// Knobs and values, in the order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = (&Knob, KnobValue)> {
        self.0.iter().map(|(knob, value)| (knob, *value))
    }

    /// Knobs and values to change; a value must keep its kind and range.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&Knob, &mut KnobValue)> {
        self.0.iter_mut().map(|(knob, value)| (&*knob, value))
    }

    /// Value of the toggle `name`.
    pub fn toggle(&self, name: &str) -> bool {
        match self.value(name) {
            KnobValue::Toggle(value) => value,
            other => panic!("knob `{name}` is no toggle but {other:?}"),
        }
    }

    /// Value of the real number `name`.
    pub fn float(&self, name: &str) -> f32 {
        match self.value(name) {
            KnobValue::Float(value) => value,
            other => panic!("knob `{name}` is no float but {other:?}"),
        }
    }

    /// Value of the whole number `name`.
    pub fn integer(&self, name: &str) -> u32 {
        match self.value(name) {
            KnobValue::Integer(value) => value,
            other => panic!("knob `{name}` is no integer but {other:?}"),
        }
    }

    /// The chosen name of the choice `name`.
    pub fn choice(&self, name: &str) -> &'static str {
        match self.value(name) {
            KnobValue::Choice(value) => value,
            other => panic!("knob `{name}` is no choice but {other:?}"),
        }
    }

    fn value(&self, name: &str) -> KnobValue {
        match self.0.iter().find(|(knob, _)| knob.name == name) {
            Some((_, value)) => *value,
            None => panic!("the scene declares no knob `{name}`"),
        }
    }
}

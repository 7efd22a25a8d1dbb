//! The knobs of a scene with their values.

use bevy::ecs::resource::Resource;
use thiserror::Error;

use super::{Knob, KnobValue};

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

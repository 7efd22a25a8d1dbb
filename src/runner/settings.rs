//! The settings of a scene with their values.

use bevy::ecs::resource::Resource;
use thiserror::Error;

use super::{SceneSetting, SettingValue};

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

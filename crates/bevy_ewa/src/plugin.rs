//! The plugin, which registers what the other modules define.

use bevy::prelude::*;

use crate::{
    material::{AllMaterials, EwaMaterialPlugin},
    mips::load::MipLoadPlugin,
    settings::EwaSettings,
    shaders::EwaShadersPlugin,
};

/// Filters the texture maps of materials with elliptical footprints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EwaPlugin {
    /// Settings of the filter for all `StandardMaterial`s of the app, whose assets stay unchanged. With
    /// `None`, only materials of the type [`EwaStandardMaterial`](crate::EwaStandardMaterial) are
    /// filtered. [`AllMaterials`] changes this value while the app runs. Default:
    /// [`EwaSettings::default`].
    pub all_materials: Option<EwaSettings>,
}

impl Default for EwaPlugin {
    fn default() -> Self {
        Self {
            all_materials: Some(EwaSettings::default()),
        }
    }
}

impl EwaPlugin {
    /// The plugin that filters only materials of the type
    /// [`EwaStandardMaterial`](crate::EwaStandardMaterial).
    pub const OPT_IN: Self = Self {
        all_materials: None,
    };
}

impl Plugin for EwaPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(AllMaterials(self.all_materials))
            .add_plugins((EwaShadersPlugin, EwaMaterialPlugin, MipLoadPlugin));
    }
}

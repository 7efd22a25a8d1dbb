//! The plugin: it registers what the modules define.

use bevy::{prelude::*, shader::load_shader_library};

use crate::{
    material::{AllMaterials, EwaMaterialPlugin},
    mips::load::MipLoadPlugin,
    settings::EwaSettings,
};

/// Filters the maps of materials by the ellipses that pixels are in their textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EwaPlugin {
    /// How all `StandardMaterial`s of the app are filtered, unchanged as they are; none for chosen
    /// ones only, by [`EwaStandardMaterial`](crate::EwaStandardMaterial). [`AllMaterials`] is the
    /// same while the app runs. Default: [`EwaSettings::default`].
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
    /// For materials that ask for it.
    pub const CHOSEN: Self = Self {
        all_materials: None,
    };
}

impl Plugin for EwaPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "shaders/types.wesl");
        load_shader_library!(app, "shaders/kernel.wesl");
        load_shader_library!(app, "shaders/footprint.wesl");
        load_shader_library!(app, "shaders/exact.wesl");
        load_shader_library!(app, "shaders/probes.wesl");
        load_shader_library!(app, "shaders/ewa.wesl");
        load_shader_library!(app, "shaders/material.wesl");
        app.insert_resource(AllMaterials(self.all_materials))
            .add_plugins((EwaMaterialPlugin, MipLoadPlugin));
    }
}

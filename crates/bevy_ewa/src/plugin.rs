//! The plugin, which registers what the other modules define.

use bevy::{prelude::*, shader::load_shader_library};

use crate::{
    material::{AllMaterials, MaterialsPlugin},
    settings::{EwaMethod, EwaSettings},
};

/// Gives the textures of materials mip levels and 16x anisotropy, or filters them by ellipses.
///
/// What each texture got is in [`EwaReport`](crate::EwaReport). [`EwaOverrides`](crate::EwaOverrides) leaves out images
/// and materials, and [`EwaMaterialPlugin`](crate::EwaMaterialPlugin) adds other types of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EwaPlugin {
    /// Settings of the filter for all `StandardMaterial`s of the app, whose assets stay unchanged. With
    /// `None`, only materials of the type [`EwaStandardMaterial`](crate::EwaStandardMaterial) are
    /// filtered. [`AllMaterials`] changes this value while the app runs. Default:
    /// [`EwaMethod::Anisotropic`], which costs no instruction in a shader.
    pub all_materials: Option<EwaSettings>,
}

impl Default for EwaPlugin {
    fn default() -> Self {
        Self {
            all_materials: AllMaterials::default().0,
        }
    }
}

impl EwaPlugin {
    /// The plugin that filters only materials of the type
    /// [`EwaStandardMaterial`](crate::EwaStandardMaterial).
    pub const OPT_IN: Self = Self {
        all_materials: None,
    };

    /// The plugin that filters all materials by ellipses: [`EwaMethod::Linear`], which is exact.
    pub fn elliptical() -> Self {
        Self::with_method(EwaMethod::Linear)
    }

    /// The plugin that filters all materials by a method.
    pub fn with_method(method: EwaMethod) -> Self {
        Self {
            all_materials: Some(EwaSettings::with_method(method)),
        }
    }
}

impl Plugin for EwaPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "shaders/texture.wesl");
        load_shader_library!(app, "shaders/types.wesl");
        load_shader_library!(app, "shaders/footprint.wesl");
        load_shader_library!(app, "shaders/exact.wesl");
        load_shader_library!(app, "shaders/probes.wesl");
        load_shader_library!(app, "shaders/stochastic.wesl");
        load_shader_library!(app, "shaders/ewa.wesl");
        app.insert_resource(AllMaterials(self.all_materials))
            .add_plugins(MaterialsPlugin);
    }
}

//! Filtering of single materials, by a material extension.

use bevy::{
    pbr::{ExtendedMaterial, MaterialExtension, StandardMaterial},
    prelude::*,
    render::render_resource::AsBindGroup,
};

use crate::settings::EwaSettings;

/// A `StandardMaterial` whose maps are filtered by the settings of its extension.
pub type EwaStandardMaterial = ExtendedMaterial<StandardMaterial, EwaExtension>;

/// The extension that holds the settings for one material's maps.
#[derive(Asset, AsBindGroup, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct EwaExtension {
    /// Settings of the filter. Changing them builds a new pipeline.
    pub settings: EwaSettings,
}

impl From<EwaSettings> for EwaExtension {
    fn from(settings: EwaSettings) -> Self {
        Self { settings }
    }
}

impl MaterialExtension for EwaExtension {}

//! Filtering of single materials, by a material extension.

use bevy::{
    mesh::MeshVertexBufferLayoutRef,
    pbr::{
        ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline,
        StandardMaterial,
    },
    prelude::*,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
};

use super::{llvmpipe::is_llvmpipe, pipeline::EwaKey};
use crate::settings::EwaSettings;

/// A `StandardMaterial` whose maps are filtered by the settings of its extension.
pub type EwaStandardMaterial = ExtendedMaterial<StandardMaterial, EwaExtension>;

/// The extension that holds the settings for one material's maps.
#[derive(Asset, AsBindGroup, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[bind_group_data(EwaKey)]
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

impl From<&EwaExtension> for EwaKey {
    fn from(extension: &EwaExtension) -> Self {
        Self::new(&extension.settings, is_llvmpipe())
    }
}

impl MaterialExtension for EwaExtension {
    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        key.bind_group_data.apply(key.mesh_key, descriptor);
        Ok(())
    }
}

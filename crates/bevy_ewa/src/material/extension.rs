//! For chosen materials.

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

use super::{all::is_software, pipeline::EwaKey};
use crate::settings::EwaSettings;

/// A `StandardMaterial` whose maps are filtered as its extension says.
pub type EwaStandardMaterial = ExtendedMaterial<StandardMaterial, EwaExtension>;

/// How the maps of a material are filtered.
#[derive(Asset, AsBindGroup, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[bind_group_data(EwaKey)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct EwaExtension {
    /// How. Changing it builds a new pipeline.
    pub settings: EwaSettings,
}

impl From<EwaSettings> for EwaExtension {
    fn from(settings: EwaSettings) -> Self {
        Self { settings }
    }
}

impl From<&EwaExtension> for EwaKey {
    fn from(extension: &EwaExtension) -> Self {
        Self::new(&extension.settings, is_software())
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

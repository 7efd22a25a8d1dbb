//! Ellipses, and the regions that are too anisotropic for texture units.

use bevy::{
    asset::{AssetPath, embedded_asset, embedded_path},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{Material, MaterialPipeline, MaterialPipelineKey},
    prelude::*,
    render::render_resource::{
        AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    },
    shader::ShaderRef,
};
use bevy_ewa::{EwaSettings, EwaUniform};

#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct ViewMaterial {
    #[uniform(0)]
    settings: EwaUniform,
    /// 0 for ellipses, 1 for regions.
    #[uniform(1)]
    view: Vec4,
    #[texture(2)]
    #[sampler(3)]
    texture: Handle<Image>,
}

impl ViewMaterial {
    pub fn new(view: &str, settings: &EwaSettings, texture: Handle<Image>) -> Self {
        let view = if view == "regions" { 1.0 } else { 0.0 };
        Self {
            settings: EwaUniform::new(settings),
            view: Vec4::splat(view),
            texture,
        }
    }
}

impl Material for ViewMaterial {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Path(AssetPath::from(embedded_path!("view.wesl")).with_source("embedded"))
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

/// Puts the shader into the binary.
pub fn embed(app: &mut App) {
    embedded_asset!(app, "view.wesl");
}

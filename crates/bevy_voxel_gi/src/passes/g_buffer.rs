//! The G-buffer of a camera, as the passes after its prepass read it; `g_buffer.wesl` declares the same.

use bevy::{
    core_pipeline::prepass::ViewPrepassTextures,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            ShaderStages, TextureSampleType,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer},
        },
        view::{ViewUniform, ViewUniforms},
    },
};

use super::bindings::BindGroups;

/// The layout of group 2.
pub(super) fn g_buffer_layout() -> BindGroupLayoutDescriptor {
    BindGroupLayoutDescriptor::new(
        "voxel_gi_g_buffer",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<ViewUniform>(true),
                texture_depth_2d(),
                texture_2d(TextureSampleType::Uint),
            ),
        ),
    )
}

/// Group 2; `None` if the camera has no G-buffer.
pub(super) fn g_buffer(
    textures: &ViewPrepassTextures,
    views: &ViewUniforms,
    groups: &BindGroups,
) -> Option<BindGroup> {
    let depth = textures.depth_only_view()?;
    let deferred = textures.deferred_view()?;
    let view = views.uniforms.binding()?;
    Some(groups.device.create_bind_group(
        "voxel_gi_g_buffer",
        &groups.cache.get_bind_group_layout(&g_buffer_layout()),
        &BindGroupEntries::sequential((view, depth, deferred)),
    ))
}

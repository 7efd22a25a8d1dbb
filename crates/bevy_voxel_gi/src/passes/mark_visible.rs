//! Marks what cameras see, for the voxels of the next frame (thesis section 6.4.3), with
//! [`Voxelizer::Stochastic`](crate::Voxelizer::Stochastic) and
//! [`VoxelAlbedo::Reprojected`](crate::VoxelAlbedo::Reprojected).
//!
//! The pass runs after the prepass of each camera that has a G-buffer. `voxelize::visible` adds the result to the voxels.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, PipelineCache,
            ShaderStages,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    bindings::{VISIBLE, VOLUME, read_write, volume_uniform},
    g_buffer::{g_buffer, g_buffer_layout},
    kernel::{Kernel, record_pass},
};
use crate::{
    extract::volume::ExtractedVolume,
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        plan::FramePlan,
        uniforms::VolumeUniforms,
    },
};

/// Pixels along an edge of a workgroup.
const TILE: u32 = 8;

#[derive(Resource)]
pub(crate) struct MarkVisiblePass {
    volume_layout: BindGroupLayoutDescriptor,
    visible_layout: BindGroupLayoutDescriptor,
    mark_visible: Kernel,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let compute = ShaderStages::COMPUTE;
    let volume_layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_mark_visible_volume",
        &BindGroupLayoutEntries::with_indices(compute, ((VOLUME, volume_uniform()),)),
    );
    let visible_layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_mark_visible",
        &BindGroupLayoutEntries::with_indices(compute, ((VISIBLE, read_write()),)),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "mark_visible.wesl");
    let layout = [&volume_layout, &visible_layout, &g_buffer_layout()];
    commands.insert_resource(MarkVisiblePass {
        mark_visible: Kernel::new(
            "voxel_gi_mark_visible",
            "mark_visible",
            &shader,
            layout.map(Clone::clone).to_vec(),
        ),
        volume_layout,
        visible_layout,
    });
}

/// Queues the pipeline once a volume voxelises what is visible; nothing waits for it.
pub(crate) fn queue(
    mut pass: ResMut<MarkVisiblePass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
) {
    let shape = volume.0.as_ref().map(BufferShape::of);
    if shape.is_some_and(|shape| shape.marks_visible) {
        pass.mark_visible.choose(&[], &cache);
    }
}

/// Runs for the camera whose prepass has just been rendered.
pub(crate) fn mark_visible(
    view: ViewQuery<(&ViewUniformOffset, &ViewPrepassTextures, &ExtractedCamera)>,
    mut context: RenderContext,
    pass: Res<MarkVisiblePass>,
    plan: Res<FramePlan>,
    (buffers, uniforms): (Option<Res<VolumeBuffers>>, Res<VolumeUniforms>),
    views: Res<ViewUniforms>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
) {
    let (offset, textures, camera) = view.into_inner();
    let (Some(_), Some(buffers)) = (plan.work, buffers) else {
        return;
    };
    if !buffers.shape.marks_visible {
        return;
    }
    let (Some(pipeline), Some(volume), Some(size), Some(g_buffer)) = (
        pass.mark_visible.pipeline(&cache),
        uniforms.bounces[0].binding(),
        camera.physical_viewport_size,
        g_buffer(textures, &views, &cache, &device),
    ) else {
        return;
    };
    let volume = device.create_bind_group(
        "voxel_gi_mark_visible_volume",
        &cache.get_bind_group_layout(&pass.volume_layout),
        &BindGroupEntries::with_indices(((VOLUME, volume),)),
    );
    let visible = device.create_bind_group(
        "voxel_gi_mark_visible",
        &cache.get_bind_group_layout(&pass.visible_layout),
        &BindGroupEntries::with_indices(((VISIBLE, buffers.visible.as_entire_binding()),)),
    );
    record_pass(&mut context, "voxel_gi_mark_visible", |pass| {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &volume, &[]);
        pass.set_bind_group(1, &visible, &[]);
        pass.set_bind_group(2, &g_buffer, &[offset.offset]);
        pass.dispatch_workgroups(size.x.div_ceil(TILE), size.y.div_ceil(TILE), 1);
    });
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "mark_visible.wesl");
}

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
        render_resource::{BindGroupLayoutDescriptor, PipelineCache},
        renderer::{RenderContext, ViewQuery},
        view::{ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    bindings::{BindGroups, VISIBLE, VOLUME, group_layout, read_write, volume_uniform},
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
    let volume_layout = group_layout(
        "voxel_gi_mark_visible_volume",
        ((VOLUME, volume_uniform()),),
    );
    let visible_layout = group_layout("voxel_gi_mark_visible", ((VISIBLE, read_write()),));
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
    groups: BindGroups,
) {
    let (offset, textures, camera) = view.into_inner();
    let (Some(_), Some(buffers)) = (plan.work, buffers) else {
        return;
    };
    if !buffers.shape.marks_visible {
        return;
    }
    let (Some(pipeline), Some(volume), Some(size), Some(g_buffer)) = (
        pass.mark_visible.pipeline(&groups.cache),
        uniforms.bounces[0].binding(),
        camera.physical_viewport_size,
        g_buffer(textures, &views, &groups),
    ) else {
        return;
    };
    let volume = groups.create(&pass.volume_layout, ((VOLUME, volume),));
    let visible = groups.create(
        &pass.visible_layout,
        ((VISIBLE, buffers.visible.as_entire_binding()),),
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

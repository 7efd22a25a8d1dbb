//! Reprojects the albedo of surfaces from cameras' G-buffers (thesis section 6.5.2), for
//! [`VoxelAlbedo::Reprojected`](crate::VoxelAlbedo::Reprojected).
//!
//! The pass runs after the prepass of each camera that has a G-buffer; the light of the next frame uses
//! the result.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        render_resource::{BindGroupLayoutDescriptor, PipelineCache},
        renderer::{RenderContext, ViewQuery},
        view::{ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    bindings::{
        BindGroups, COLORS, FACE_SLOTS, MASKS, PACKED_SURFACES, REPROJECTED_ALBEDO, VOLUME, WORK,
        group_layout, read_only, read_write, volume_uniform,
    },
    g_buffer::{g_buffer, g_buffer_layout},
    kernel::{Kernel, record_pass},
};
use crate::{
    extract::volume::ExtractedVolume,
    prepare::{buffers::VolumeBuffers, plan::FramePlan, uniforms::VolumeUniforms},
    settings::VoxelAlbedo,
};

#[derive(Resource)]
pub(crate) struct ReprojectPass {
    voxels_layout: BindGroupLayoutDescriptor,
    work_layout: BindGroupLayoutDescriptor,
    reproject: Kernel,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let voxels_layout = group_layout(
        "voxel_gi_reproject_volume",
        (
            (VOLUME, volume_uniform()),
            (MASKS, read_only()),
            (PACKED_SURFACES, read_only()),
            (FACE_SLOTS, read_only()),
            (REPROJECTED_ALBEDO, read_write()),
        ),
    );
    let work_layout = group_layout(
        "voxel_gi_reproject_work",
        ((WORK, read_only()), (COLORS, read_only())),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "reproject.wesl");
    let layout = [&voxels_layout, &work_layout, &g_buffer_layout()];
    commands.insert_resource(ReprojectPass {
        reproject: Kernel::new(
            "voxel_gi_reproject",
            "reproject",
            &shader,
            layout.map(Clone::clone).to_vec(),
        )
        .with_zeroed_workgroup_memory(),
        voxels_layout,
        work_layout,
    });
}

/// Queues the pipeline once a volume uses reprojected albedo; nothing waits for it.
pub(crate) fn queue(
    mut pass: ResMut<ReprojectPass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
) {
    let volume = volume.0.as_ref();
    if volume.is_some_and(|volume| volume.settings.albedo == VoxelAlbedo::Reprojected) {
        pass.reproject.choose(&[], &cache);
    }
}

/// Runs for the camera whose prepass has just been rendered.
pub(crate) fn reproject(
    view: ViewQuery<(&ViewUniformOffset, &ViewPrepassTextures)>,
    mut context: RenderContext,
    pass: Res<ReprojectPass>,
    plan: Res<FramePlan>,
    (buffers, uniforms): (Option<Res<VolumeBuffers>>, Res<VolumeUniforms>),
    views: Res<ViewUniforms>,
    groups: BindGroups,
) {
    let (offset, textures) = view.into_inner();
    let (Some(_), Some(buffers)) = (plan.work, buffers) else {
        return;
    };
    if !buffers.shape.reprojects_albedo {
        return;
    }
    let (Some(pipeline), Some(volume), Some(g_buffer)) = (
        pass.reproject.pipeline(&groups.cache),
        uniforms.bounces[0].binding(),
        g_buffer(textures, &views, &groups),
    ) else {
        return;
    };
    let voxels = groups.create(
        &pass.voxels_layout,
        (
            (VOLUME, volume),
            (MASKS, buffers.masks()),
            (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
            (FACE_SLOTS, buffers.face_slots()),
            (
                REPROJECTED_ALBEDO,
                buffers.reprojected_albedo.as_entire_binding(),
            ),
        ),
    );
    let work = groups.create(
        &pass.work_layout,
        (
            (WORK, buffers.work.as_entire_binding()),
            (COLORS, buffers.colors()),
        ),
    );
    record_pass(&mut context, "voxel_gi_reproject", |pass| {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &voxels, &[]);
        pass.set_bind_group(1, &work, &[]);
        pass.set_bind_group(2, &g_buffer, &[offset.offset]);
        pass.dispatch_workgroups_indirect(&buffers.indirect_args, VolumeBuffers::SURFACE_ARGS);
    });
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "reproject.wesl");
}

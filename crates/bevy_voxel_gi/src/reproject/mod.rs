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
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            CachedComputePipelineId, ComputePassDescriptor, ComputePipelineDescriptor,
            PipelineCache, ShaderStages, TextureSampleType,
            binding_types::{
                storage_buffer_read_only_sized, storage_buffer_sized, texture_2d, texture_depth_2d,
                uniform_buffer,
            },
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use crate::{
    settings::VoxelAlbedo,
    volume::{
        gpu::{GpuVolume, VolumeBuffers, VolumeUniforms},
        plan::{ExtractedVolume, FramePlan},
    },
};

#[derive(Resource)]
pub(crate) struct ReprojectPipeline {
    volume: BindGroupLayoutDescriptor,
    view: BindGroupLayoutDescriptor,
    shader: Handle<Shader>,
    /// Created when it is first needed.
    id: Option<CachedComputePipelineId>,
}

pub(crate) fn init_reproject_pipeline(mut commands: Commands, assets: Res<AssetServer>) {
    let read = || storage_buffer_read_only_sized(false, None);
    let compute = ShaderStages::COMPUTE;
    commands.insert_resource(ReprojectPipeline {
        volume: BindGroupLayoutDescriptor::new(
            "voxel_gi_reproject_volume",
            &BindGroupLayoutEntries::sequential(
                compute,
                (uniform_buffer::<GpuVolume>(false), read(), read()),
            ),
        ),
        view: BindGroupLayoutDescriptor::new(
            "voxel_gi_reproject_view",
            &BindGroupLayoutEntries::sequential(
                compute,
                (
                    read(),
                    read(),
                    storage_buffer_sized(false, None),
                    uniform_buffer::<ViewUniform>(true),
                    texture_depth_2d(),
                    texture_2d(TextureSampleType::Uint),
                ),
            ),
        ),
        shader: load_embedded_asset!(assets.as_ref(), "reproject.wesl"),
        id: None,
    });
}

/// Queues the pipeline once a volume uses reprojected albedo.
pub(crate) fn prepare_reprojection(
    mut pipeline: ResMut<ReprojectPipeline>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
) {
    let wanted = volume
        .0
        .as_ref()
        .is_some_and(|volume| volume.settings.albedo == VoxelAlbedo::Reprojected);
    if wanted && pipeline.id.is_none() {
        pipeline.id = Some(cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label: Some("voxel_gi_reproject".into()),
            layout: vec![pipeline.volume.clone(), pipeline.view.clone()],
            shader: pipeline.shader.clone(),
            entry_point: Some("reproject".into()),
            zero_initialize_workgroup_memory: true,
            ..default()
        }));
    }
}

/// Runs for the camera whose prepass has just been rendered.
pub(crate) fn reproject(
    view: ViewQuery<(&ViewUniformOffset, &ViewPrepassTextures)>,
    mut context: RenderContext,
    plan: Res<FramePlan>,
    (buffers, uniforms): (Option<Res<VolumeBuffers>>, Res<VolumeUniforms>),
    views: Res<ViewUniforms>,
    pipeline: Res<ReprojectPipeline>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
) {
    let (offset, textures) = view.into_inner();
    let (Some(buffers), true) = (buffers, plan.light.is_some()) else {
        return;
    };
    let (Some(deferred), Some(depth)) = (textures.deferred_view(), textures.depth_only_view())
    else {
        return;
    };
    let ready = pipeline.id.and_then(|id| cache.get_compute_pipeline(id));
    let (true, Some(ready)) = (buffers.shape.reprojects_albedo, ready) else {
        return;
    };
    let (Some(uniform), Some(view_uniform)) =
        (uniforms.bounces[0].binding(), views.uniforms.binding())
    else {
        return;
    };
    let volume_group = device.create_bind_group(
        "voxel_gi_reproject_volume",
        &cache.get_bind_group_layout(&pipeline.volume),
        &BindGroupEntries::sequential((
            uniform,
            buffers.masks.as_entire_binding(),
            buffers.packed_surfaces.as_entire_binding(),
        )),
    );
    let view_group = device.create_bind_group(
        "voxel_gi_reproject_view",
        &cache.get_bind_group_layout(&pipeline.view),
        &BindGroupEntries::sequential((
            buffers.work.as_entire_binding(),
            buffers.counters.as_entire_binding(),
            buffers.reprojected_albedo.as_entire_binding(),
            view_uniform,
            depth,
            deferred,
        )),
    );
    let diagnostics = context.diagnostic_recorder();
    let encoder = context.command_encoder();
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some("voxel_gi_reproject"),
        ..default()
    });
    let span = diagnostics
        .as_ref()
        .map(|d| d.pass_span(&mut pass, "voxel_gi_reproject"));
    pass.set_pipeline(ready);
    pass.set_bind_group(0, &volume_group, &[]);
    pass.set_bind_group(1, &view_group, &[offset.offset]);
    pass.dispatch_workgroups_indirect(&buffers.dispatch, 0);
    if let Some(span) = span {
        span.end(&mut pass);
    }
}

/// Embeds the shader.
pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "reproject.wesl");
}

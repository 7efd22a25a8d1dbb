//! Light transport between the voxels: direct light (thesis section 6.5.4), and indirect light from
//! surface to surface (sections 6.6.1 and 6.6.2).

pub(crate) mod pipeline;

use bevy::{
    asset::embedded_asset,
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, Buffer, ComputePass, ComputePassDescriptor,
            ComputePipeline, PipelineCache, StorageBuffer,
        },
        renderer::{RenderContext, RenderDevice},
        texture::GpuImage,
    },
};

use self::pipeline::{LightPipelines, SolverIds};
use crate::{
    scene::{lights::GpuLight, voxel_material::VoxelMaterial},
    volume::{
        gpu::{VolumeBuffers, VolumeUniforms},
        plan::FramePlan,
    },
};

/// The bind groups of a frame in which light is computed.
#[derive(Resource)]
pub(crate) struct LightWork {
    /// The surface table, on the GPU.
    pub surfaces: Buffer,
    /// For the first bounce of the frame, and for the later ones.
    volume: [BindGroup; 2],
    compact: BindGroup,
    inject: BindGroup,
    gather: BindGroup,
    /// Ping-pong between the two buffers of intensities.
    propagate: [BindGroup; 2],
}

impl LightWork {
    pub(crate) fn new(
        surfaces: &StorageBuffer<Vec<VoxelMaterial>>,
        lights: &StorageBuffer<Vec<GpuLight>>,
        texture: &GpuImage,
        uniforms: &VolumeUniforms,
        buffers: &VolumeBuffers,
        pipelines: &LightPipelines,
        cache: &PipelineCache,
        device: &RenderDevice,
    ) -> Option<Self> {
        let volume = |bounce: usize| {
            Some(device.create_bind_group(
                "voxel_gi_volume",
                &cache.get_bind_group_layout(&pipelines.volume),
                &BindGroupEntries::sequential((
                    uniforms.bounces[bounce].binding()?,
                    buffers.masks.as_entire_binding(),
                    buffers.packed_surfaces.as_entire_binding(),
                    buffers.reprojected_albedo.as_entire_binding(),
                )),
            ))
        };
        let propagate = |from: usize| {
            Some(device.create_bind_group(
                "voxel_gi_propagate",
                &cache.get_bind_group_layout(&pipelines.propagate),
                &BindGroupEntries::sequential((
                    buffers.radiance.as_entire_binding(),
                    surfaces.binding()?,
                    buffers.intensity[from].as_entire_binding(),
                    buffers.intensity[1 - from].as_entire_binding(),
                    buffers.irradiance.as_entire_binding(),
                    &texture.texture_view,
                )),
            ))
        };
        Some(Self {
            surfaces: surfaces.buffer()?.clone(),
            volume: [volume(0)?, volume(1)?],
            propagate: [propagate(0)?, propagate(1)?],
            compact: device.create_bind_group(
                "voxel_gi_compact",
                &cache.get_bind_group_layout(&pipelines.compact),
                &BindGroupEntries::sequential((
                    buffers.work.as_entire_binding(),
                    buffers.counters.as_entire_binding(),
                    &texture.texture_view,
                    buffers.irradiance.as_entire_binding(),
                )),
            ),
            inject: device.create_bind_group(
                "voxel_gi_inject",
                &cache.get_bind_group_layout(&pipelines.inject),
                &BindGroupEntries::sequential((
                    buffers.work.as_entire_binding(),
                    buffers.counters.as_entire_binding(),
                    buffers.radiance.as_entire_binding(),
                    surfaces.binding()?,
                    lights.binding()?,
                    buffers.irradiance.as_entire_binding(),
                )),
            ),
            gather: device.create_bind_group(
                "voxel_gi_gather",
                &cache.get_bind_group_layout(&pipelines.gather),
                &BindGroupEntries::sequential((
                    buffers.work.as_entire_binding(),
                    buffers.counters.as_entire_binding(),
                    buffers.radiance.as_entire_binding(),
                    &texture.texture_view,
                    buffers.irradiance.as_entire_binding(),
                )),
            ),
        })
    }
}

/// Byte offsets of the indirect dispatch arguments of the passes over surfaces and over empty voxels.
const SURFACES: u64 = 0;
const EMPTY_VOXELS: u64 = 16;

/// Compacts the work, then computes each bounce.
pub(crate) fn compute_light(
    mut context: RenderContext,
    plan: Res<FramePlan>,
    work: Option<Res<LightWork>>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some(ids), Some(work), Some(buffers)) = (plan.light, work, buffers) else {
        return;
    };
    let ready = |id| cache.get_compute_pipeline(id);
    let (Some(compact), Some(write_indirect_args)) =
        (ready(ids.compact), ready(ids.write_indirect_args))
    else {
        return;
    };
    let inject = ids.inject.and_then(ready);
    compute_pass(&mut context, "voxel_gi_compact", |pass| {
        pass.set_bind_group(0, &work.volume[0], &[]);
        pass.set_bind_group(1, &work.compact, &[]);
        over_voxels(pass, compact, &buffers);
        pass.set_pipeline(write_indirect_args);
        pass.dispatch_workgroups(1, 1, 1);
    });
    // A buffer cannot be both writable storage and indirect arguments in one pass.
    context.command_encoder().copy_buffer_to_buffer(
        &buffers.counters,
        VolumeBuffers::SIZES,
        &buffers.dispatch,
        0,
        VolumeBuffers::DISPATCH,
    );
    match ids.solver {
        SolverIds::Trace { surfaces, empty } => {
            let (Some(surfaces), Some(empty)) = (ready(surfaces), ready(empty)) else {
                return;
            };
            for bounce in 0..plan.bounces {
                let volume = &work.volume[usize::from(bounce > 0)];
                if let Some(inject) = inject {
                    compute_pass(&mut context, "voxel_gi_inject", |pass| {
                        run(pass, inject, volume, &work.inject, &buffers, SURFACES);
                    });
                }
                compute_pass(&mut context, "voxel_gi_gather", |pass| {
                    run(pass, surfaces, volume, &work.gather, &buffers, SURFACES);
                    if bounce + 1 == plan.bounces {
                        run(pass, empty, volume, &work.gather, &buffers, EMPTY_VOXELS);
                    }
                });
            }
        }
        SolverIds::Propagate {
            seed,
            step: one_step,
            deposit,
        } => {
            let (Some(seed), Some(one_step), Some(deposit), Some(inject)) =
                (ready(seed), ready(one_step), ready(deposit), inject)
            else {
                return;
            };
            compute_pass(&mut context, "voxel_gi_inject", |pass| {
                run(
                    pass,
                    inject,
                    &work.volume[0],
                    &work.inject,
                    &buffers,
                    SURFACES,
                );
            });
            compute_pass(&mut context, "voxel_gi_propagate", |pass| {
                pass.set_bind_group(0, &work.volume[0], &[]);
                // `seed` writes the first buffer, which the first compute_pass reads.
                pass.set_bind_group(1, &work.propagate[1], &[]);
                over_voxels(pass, seed, &buffers);
                for number in 0..plan.iterations {
                    pass.set_bind_group(1, &work.propagate[number as usize % 2], &[]);
                    over_voxels(pass, one_step, &buffers);
                }
                over_voxels(pass, deposit, &buffers);
            });
        }
    }
}

/// Dispatches one thread per voxel.
fn over_voxels(pass: &mut ComputePass<'_>, pipeline: &ComputePipeline, buffers: &VolumeBuffers) {
    let groups = u32::try_from(buffers.shape.voxels.div_ceil(64)).unwrap_or(u32::MAX);
    let x = groups.min(32768);
    pass.set_pipeline(pipeline);
    pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
}

/// Records a compute pass with a timing span.
fn compute_pass(
    context: &mut RenderContext,
    name: &'static str,
    record: impl FnOnce(&mut ComputePass<'_>),
) {
    let diagnostics = context.diagnostic_recorder();
    let encoder = context.command_encoder();
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some(name),
        ..default()
    });
    let span = diagnostics.as_ref().map(|d| d.pass_span(&mut pass, name));
    record(&mut pass);
    if let Some(span) = span {
        span.end(&mut pass);
    }
}

fn run(
    pass: &mut ComputePass<'_>,
    pipeline: &ComputePipeline,
    volume: &BindGroup,
    group: &BindGroup,
    buffers: &VolumeBuffers,
    size: u64,
) {
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, volume, &[]);
    pass.set_bind_group(1, group, &[]);
    pass.dispatch_workgroups_indirect(&buffers.dispatch, size);
}

/// Embeds the shaders of the passes.
pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "compact.wesl");
    embedded_asset!(app, "inject.wesl");
    embedded_asset!(app, "gather.wesl");
    embedded_asset!(app, "propagate.wesl");
}

//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5).

pub(crate) mod instances;
pub(crate) mod pipeline;

use bevy::{
    asset::embedded_asset,
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, BufferDescriptor, BufferUsages, ComputePassDescriptor,
            PipelineCache, StorageBuffer,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use self::{
    instances::{Group, Instances},
    pipeline::VoxelizePipeline,
};
use crate::volume::{
    gpu::{VolumeBuffers, VolumeUniforms},
    plan::FramePlan,
};

/// The bind groups and dispatch sizes of a frame that voxelises.
#[derive(Resource)]
pub(crate) struct VoxelizeWork {
    volume: BindGroup,
    groups: Vec<(BindGroup, u32)>,
}

impl VoxelizeWork {
    pub(crate) fn new(
        instances: &Instances,
        joints: &[Mat4],
        uniforms: &VolumeUniforms,
        buffers: &VolumeBuffers,
        pipeline: &VoxelizePipeline,
        cache: &PipelineCache,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<Self> {
        let volume = device.create_bind_group(
            "voxel_gi_voxelize_volume",
            &cache.get_bind_group_layout(&pipeline.volume),
            &BindGroupEntries::sequential((
                uniforms.bounces[0].binding()?,
                buffers.masks.as_entire_binding(),
                buffers.packed_surfaces.as_entire_binding(),
            )),
        );
        let stub = device.create_buffer(&BufferDescriptor {
            label: Some("voxel_gi_none"),
            size: 16,
            usage: BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let mut joint_buffer = StorageBuffer::from(if joints.is_empty() {
            vec![Mat4::IDENTITY]
        } else {
            joints.to_vec()
        });
        joint_buffer.write_buffer(device, queue);
        let bind = |group: &Group| {
            let mut instances = StorageBuffer::from(group.instances.clone());
            instances.write_buffer(device, queue);
            let mut batches = StorageBuffer::from(group.batches.clone());
            batches.write_buffer(device, queue);
            let bind_group = device.create_bind_group(
                "voxel_gi_voxelize_meshes",
                &cache.get_bind_group_layout(&pipeline.group),
                &BindGroupEntries::sequential((
                    group.vertices.as_entire_binding(),
                    group.indices.as_ref().unwrap_or(&stub).as_entire_binding(),
                    instances.binding()?,
                    batches.binding()?,
                    joint_buffer.binding()?,
                    group
                        .morph_targets
                        .as_ref()
                        .unwrap_or(&stub)
                        .as_entire_binding(),
                )),
            );
            Some((bind_group, u32::try_from(group.batches.len()).ok()?))
        };
        Some(Self {
            volume,
            groups: instances.groups.iter().filter_map(bind).collect(),
        })
    }
}

/// Clears the volume and voxelises the scene.
pub(crate) fn voxelize(
    mut context: RenderContext,
    plan: Res<FramePlan>,
    work: Option<Res<VoxelizeWork>>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some(work), Some(buffers)) = (work, buffers) else {
        return;
    };
    let Some(pipeline) = plan
        .voxelize
        .and_then(|pipeline| cache.get_compute_pipeline(pipeline))
    else {
        return;
    };
    let diagnostics = context.diagnostic_recorder();
    let encoder = context.command_encoder();
    for buffer in [
        &buffers.masks,
        &buffers.packed_surfaces,
        &buffers.radiance,
        &buffers.counters,
    ] {
        encoder.clear_buffer(buffer, 0, None);
    }
    if plan.has_moved {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
    }
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some("voxel_gi_voxelize"),
        ..default()
    });
    let span = diagnostics
        .as_ref()
        .map(|d| d.pass_span(&mut pass, "voxel_gi_voxelize"));
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &work.volume, &[]);
    for (bind_group, batches) in &work.groups {
        const MOST: u32 = 32768;
        let x = (*batches).min(MOST);
        pass.set_bind_group(1, bind_group, &[]);
        pass.dispatch_workgroups(x, batches.div_ceil(x), 1);
    }
    if let Some(span) = span {
        span.end(&mut pass);
    }
}

/// Embeds the shaders of the voxelisers.
pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "conservative.wesl");
    embedded_asset!(app, "slices.wesl");
    embedded_asset!(app, "points.wesl");
}

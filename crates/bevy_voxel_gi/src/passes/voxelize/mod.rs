//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5), in two passes over the triangles: occupancy and the
//! faces that have a surface, then the surfaces.

mod kernels;
mod visible;

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferDescriptor, BufferUsages, ComputePass, ComputePipeline, PipelineCache,
            ShaderStages, StorageBuffer,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use super::{
    allocate::{AllocatePass, keep_slots},
    bindings::{
        BindGroups, FACE_SLOTS, MASKS, PACKED_SURFACES, VOLUME, group_layout, read_only,
        read_write, volume_uniform,
    },
    kernel::{dispatch_workgroups, record_pass},
    slot_demand::SlotDemandCopy,
};
use crate::{
    extract::{meshes::ExtractedScene, volume::ExtractedVolume},
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        mesh_batches::MeshBatches,
        mesh_group::MeshGroup,
        pipelines::RequiredPipelines,
        plan::FramePlan,
        uniforms::VolumeUniforms,
    },
    settings::Voxelizer,
};
use kernels::Kernels;
use visible::VisibleVoxels;

#[derive(Resource)]
pub(crate) struct VoxelizePass {
    /// Layout of the volume's buffers, which the voxelisers write.
    voxels_layout: BindGroupLayoutDescriptor,
    /// Layout of the buffers of a group of meshes, which the voxelisers read.
    meshes_layout: BindGroupLayoutDescriptor,
    conservative: Kernels,
    slices: Kernels,
    points: Kernels,
    visible: VisibleVoxels,
    work: Option<VoxelizeWork>,
}

/// The bind groups and dispatch sizes of a frame that voxelises.
struct VoxelizeWork {
    voxels: BindGroup,
    groups: Vec<(BindGroup, u32)>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let voxels_layout = group_layout(
        "voxel_gi_voxelize_volume",
        (
            (VOLUME, volume_uniform()),
            (MASKS, read_write()),
            (PACKED_SURFACES, read_write()),
            (FACE_SLOTS, read_write()),
        ),
    );
    let meshes_layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_voxelize_meshes",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                read_only(),
                read_only(),
                read_only(),
                read_only(),
                read_only(),
                read_only(),
            ),
        ),
    );
    let kernels = |shader: Handle<Shader>| {
        let labels = ["voxel_gi_voxelize", "voxel_gi_surfaces"];
        Kernels::new(labels, &shader, &[&voxels_layout, &meshes_layout])
    };
    commands.insert_resource(VoxelizePass {
        conservative: kernels(load_embedded_asset!(assets, "conservative.wesl")),
        slices: kernels(load_embedded_asset!(assets, "slices.wesl")),
        points: kernels(load_embedded_asset!(assets, "points.wesl")),
        visible: VisibleVoxels::new(&voxels_layout, assets),
        voxels_layout,
        meshes_layout,
        work: None,
    });
}

impl VoxelizePass {
    fn kernels(&self, voxelizer: Voxelizer) -> &Kernels {
        match voxelizer {
            Voxelizer::Conservative => &self.conservative,
            Voxelizer::FragmentClipping | Voxelizer::GeometryClipping => &self.slices,
            Voxelizer::Stochastic { .. } => &self.points,
        }
    }

    fn kernels_mut(&mut self, voxelizer: Voxelizer) -> &mut Kernels {
        match voxelizer {
            Voxelizer::Conservative => &mut self.conservative,
            Voxelizer::FragmentClipping | Voxelizer::GeometryClipping => &mut self.slices,
            Voxelizer::Stochastic { .. } => &mut self.points,
        }
    }
}

pub(crate) fn queue(
    mut pass: ResMut<VoxelizePass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let Some(volume) = &volume.0 else {
        return;
    };
    let mut defs = Vec::new();
    let voxelizer = volume.settings.voxelizer;
    if voxelizer == Voxelizer::GeometryClipping {
        defs.push("GEOMETRY_CLIPPING");
    }
    let kernels = pass.kernels_mut(voxelizer);
    kernels.require(defs, &cache, &mut required);
    if BufferShape::of(volume).marks_visible {
        pass.visible.queue(&cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<VoxelizePass>,
    plan: Res<FramePlan>,
    (mut batches, scene): (ResMut<MeshBatches>, Res<ExtractedScene>),
    buffers: Option<Res<VolumeBuffers>>,
    uniforms: Res<VolumeUniforms>,
    (groups, queue): (BindGroups, Res<RenderQueue>),
) {
    pass.work = None;
    let (Some(true), Some(buffers), Some(volume)) = (
        plan.work.map(|work| work.voxelizes),
        buffers,
        uniforms.bounces[0].binding(),
    ) else {
        return;
    };
    let voxels = groups.create(
        &pass.voxels_layout,
        (
            (VOLUME, volume),
            (MASKS, buffers.masks.as_entire_binding()),
            (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
            (FACE_SLOTS, buffers.face_slots.as_entire_binding()),
        ),
    );
    pass.visible.prepare(&buffers, &groups);
    let device = &*groups.device;
    let stub = device.create_buffer(&BufferDescriptor {
        label: Some("voxel_gi_none"),
        size: 16,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let mut joints = StorageBuffer::from(if scene.joints.is_empty() {
        vec![Mat4::IDENTITY]
    } else {
        scene.joints.clone()
    });
    joints.write_buffer(device, &queue);
    let layout = groups.cache.get_bind_group_layout(&pass.meshes_layout);
    let bind = |group: &mut MeshGroup| {
        let buffers = group.buffers.each_ref();
        let buffers = buffers.map(|buffer| buffer.clone().unwrap_or_else(|| stub.clone()));
        let [vertices, indices, morph_targets] = &buffers;
        let (instances, batches, batch_count) = group.upload(device, &queue)?;
        let bind_group = device.create_bind_group(
            "voxel_gi_voxelize_meshes",
            &layout,
            &BindGroupEntries::sequential((
                vertices.as_entire_binding(),
                indices.as_entire_binding(),
                instances,
                batches,
                joints.binding()?,
                morph_targets.as_entire_binding(),
            )),
        );
        Some((bind_group, batch_count))
    };
    pass.work = Some(VoxelizeWork {
        voxels,
        groups: batches.groups_mut().filter_map(bind).collect(),
    });
}

impl VoxelizeWork {
    /// Records one of the two passes over all meshes.
    fn record(&self, pass: &mut ComputePass<'_>, pipeline: &ComputePipeline) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.voxels, &[]);
        for (bind_group, batches) in &self.groups {
            pass.set_bind_group(1, bind_group, &[]);
            dispatch_workgroups(pass, *batches);
        }
    }
}

/// Clears the volume and voxelises the scene.
pub(crate) fn voxelize(
    mut context: RenderContext,
    (pass, allocate): (Res<VoxelizePass>, Res<AllocatePass>),
    mut demand: ResMut<SlotDemandCopy>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
) {
    let (Some(work), Some(frame), Some(volume), Some(buffers)) =
        (&pass.work, plan.work, &volume.0, buffers)
    else {
        return;
    };
    let kernels = pass.kernels(volume.settings.voxelizer);
    let Some([occupancy, surfaces]) = kernels.pipelines(&cache) else {
        return;
    };
    let encoder = context.command_encoder();
    keep_slots(encoder, &buffers);
    for buffer in [
        &buffers.masks,
        &buffers.face_slots,
        &buffers.packed_surfaces,
        &buffers.radiance,
        &buffers.counters,
    ] {
        encoder.clear_buffer(buffer, 0, None);
    }
    if frame.moves.is_some() {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
        encoder.clear_buffer(&buffers.visible, 0, None);
    }
    let visible = pass.visible.pipelines(&cache);
    record_pass(&mut context, "voxel_gi_voxelize", |compute| {
        work.record(compute, occupancy);
        if let Some([occupancy, _]) = visible {
            pass.visible
                .record(compute, occupancy, &work.voxels, &buffers);
        }
        allocate.record(compute, &buffers, &cache);
        work.record(compute, surfaces);
        if let Some([_, surfaces]) = visible {
            pass.visible
                .record(compute, surfaces, &work.voxels, &buffers);
        }
    });
    if frame.has_changed {
        pass.visible.clear(context.command_encoder(), &buffers);
    }
    demand.record(context.command_encoder(), &buffers, &device);
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "conservative.wesl");
    embedded_asset!(app, "slices.wesl");
    embedded_asset!(app, "points.wesl");
    visible::embed(app);
}

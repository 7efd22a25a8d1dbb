//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5), in two passes over the triangles: occupancy and the
//! faces that have a surface, then the surfaces.

mod kernels;
mod visible;

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, Buffer,
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
        shadow_masks::ShadowMasks,
        uniforms::VolumeUniforms,
    },
    settings::Voxelizer,
};
use kernels::Kernels;
use visible::VisibleVoxels;

#[derive(Resource)]
pub(crate) struct VoxelizePass {
    /// Layouts of the volume's buffers, which the voxelisers write in their two passes.
    voxels_layouts: [BindGroupLayoutDescriptor; 2],
    /// Layout of the buffers of a group of meshes, which the voxelisers read.
    meshes_layout: BindGroupLayoutDescriptor,
    conservative: Kernels,
    slices: Kernels,
    points: Kernels,
    visible: VisibleVoxels,
    /// Matrices of joints and weights of morph targets. It is kept: where a device is lost, a new buffer with contents
    /// would end the app.
    joints: StorageBuffer<Vec<Mat4>>,
    work: Option<VoxelizeWork>,
}

/// The bind groups and dispatch sizes of a frame that voxelises.
struct VoxelizeWork {
    voxels: [BindGroup; 2],
    groups: Vec<(BindGroup, u32)>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let voxels_layout = |label, own| {
        let entries = (
            (VOLUME, volume_uniform()),
            (own, read_write()),
            (FACE_SLOTS, read_write()),
        );
        group_layout(label, entries)
    };
    let voxels_layouts = [
        voxels_layout("voxel_gi_voxelize_volume", MASKS),
        voxels_layout("voxel_gi_surfaces_volume", PACKED_SURFACES),
    ];
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
        Kernels::new(labels, &shader, &voxels_layouts, &meshes_layout)
    };
    commands.insert_resource(VoxelizePass {
        conservative: kernels(load_embedded_asset!(assets, "conservative.wesl")),
        slices: kernels(load_embedded_asset!(assets, "slices.wesl")),
        points: kernels(load_embedded_asset!(assets, "points.wesl")),
        visible: VisibleVoxels::new(&voxels_layouts, assets),
        voxels_layouts,
        meshes_layout,
        joints: StorageBuffer::default(),
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
    shadow_masks: ShadowMasks,
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
    let shape = BufferShape::of(volume);
    let shadow_masks = shadow_masks.defs(shape);
    let kernels = pass.kernels_mut(voxelizer);
    kernels.require(&defs, shadow_masks, &cache, &mut required);
    if shape.marks_visible {
        pass.visible.queue(shadow_masks, &cache, &mut required);
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
    let [occupancy_layout, surfaces_layout] = &pass.voxels_layouts;
    let voxels = |layout, own, buffer: &Buffer| {
        let entries = (
            (VOLUME, volume.clone()),
            (own, buffer.as_entire_binding()),
            (FACE_SLOTS, buffers.face_slots.as_entire_binding()),
        );
        groups.create(layout, entries)
    };
    let voxels = [
        voxels(occupancy_layout, MASKS, &buffers.masks),
        voxels(surfaces_layout, PACKED_SURFACES, &buffers.packed_surfaces),
    ];
    pass.visible.prepare(&buffers, &groups);
    let device = &*groups.device;
    let stub = device.create_buffer(&BufferDescriptor {
        label: Some("voxel_gi_none"),
        size: 16,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let joints = pass.joints.get_mut();
    joints.clone_from(&scene.joints);
    if joints.is_empty() {
        joints.push(Mat4::IDENTITY);
    }
    pass.joints.write_buffer(device, &queue);
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
                pass.joints.binding()?,
                morph_targets.as_entire_binding(),
            )),
        );
        Some((bind_group, batch_count))
    };
    let groups = batches.groups_mut().filter_map(bind).collect();
    pass.work = Some(VoxelizeWork { voxels, groups });
}

impl VoxelizeWork {
    /// Records one of the two passes over all meshes.
    fn record(&self, pass: &mut ComputePass<'_>, pipeline: &ComputePipeline, voxels: &BindGroup) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, voxels, &[]);
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
    ] {
        encoder.clear_buffer(buffer, 0, None);
    }
    encoder.clear_buffer(&buffers.work, 0, Some(VolumeBuffers::COUNTERS_SIZE));
    if frame.moves.is_some() {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
        encoder.clear_buffer(&buffers.visible, 0, None);
    }
    let visible = pass.visible.pipelines(&cache);
    record_pass(&mut context, "voxel_gi_voxelize", |compute| {
        let [masks, packed_surfaces] = &work.voxels;
        work.record(compute, occupancy, masks);
        if let Some([occupancy, _]) = visible {
            pass.visible.record(compute, occupancy, masks, &buffers);
        }
        allocate.record(compute, &buffers, &cache);
        work.record(compute, surfaces, packed_surfaces);
        if let Some([_, surfaces]) = visible {
            pass.visible
                .record(compute, surfaces, packed_surfaces, &buffers);
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

//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5), in two passes over the triangles: occupancy and the
//! faces that have a surface, then the areas and colours of the surfaces, whose sums are resolved last.

mod kernels;
mod visible;

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferDescriptor, BufferUsages, ComputePass, ComputePipeline, PipelineCache,
            ShaderStages, StorageBuffer, TextureSampleType, binding_types::texture_2d,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use super::{
    allocate::{AllocatePass, keep_slots},
    bindings::{
        BindGroups, FACE_SLOTS, MASKS, PACKED_SURFACES, SUMS, VOLUME, group_layout, read_only,
        read_write, volume_uniform,
    },
    kernel::{Kernel, dispatch_voxels, dispatch_workgroups, record_pass},
    slot_demand::SlotDemandCopy,
};
use crate::{
    extract::{meshes::ExtractedScene, volume::ExtractedVolume},
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        materials::{EMISSION, MaterialRecords},
        mesh_batches::MeshBatches,
        mesh_group::MeshGroup,
        pipelines::RequiredPipelines,
        plan::FramePlan,
        shadow_masks::ShadowMasks,
        tiles::Tiles,
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
    resolve_layout: BindGroupLayoutDescriptor,
    resolve: Kernel,
    /// Matrices of joints and weights of morph targets. It is kept: where a device is lost, a new buffer with contents
    /// would end the app.
    joints: StorageBuffer<Vec<Mat4>>,
    work: Option<VoxelizeWork>,
}

/// The bind groups and dispatch sizes of a frame that voxelises.
struct VoxelizeWork {
    voxels: [BindGroup; 2],
    resolve: BindGroup,
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
        voxels_layout("voxel_gi_surfaces_volume", SUMS),
    ];
    let resolve_layout = group_layout(
        "voxel_gi_resolve",
        (
            (VOLUME, volume_uniform()),
            (MASKS, read_only()),
            (PACKED_SURFACES, read_write()),
            (FACE_SLOTS, read_only()),
            (SUMS, read_write()),
        ),
    );
    let integers = || texture_2d(TextureSampleType::Uint);
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
                integers(),
                integers(),
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
        resolve: Kernel::new(
            "voxel_gi_resolve",
            "resolve",
            &load_embedded_asset!(assets, "resolve.wesl"),
            vec![resolve_layout.clone()],
        ),
        resolve_layout,
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
    (volume, materials): (Res<ExtractedVolume>, Res<MaterialRecords>),
    shadow_masks: ShadowMasks,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let Some(volume) = &volume.0 else {
        return;
    };
    let mut defs = materials.defs();
    let voxelizer = volume.settings.voxelizer;
    if voxelizer == Voxelizer::GeometryClipping {
        for defs in &mut defs {
            defs.push("GEOMETRY_CLIPPING");
        }
    }
    let shape = BufferShape::of(volume);
    let shadow_masks = shadow_masks.defs(shape);
    defs[0].extend(shadow_masks);
    let kernels = pass.kernels_mut(voxelizer);
    kernels.require(defs.each_ref().map(Vec::as_slice), &cache, &mut required);
    let emission = (materials.emission_unit > 0.0).then_some(EMISSION);
    pass.resolve
        .require(emission.as_slice(), &cache, &mut required);
    if shape.marks_visible {
        pass.visible.queue(shadow_masks, &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<VoxelizePass>,
    plan: Res<FramePlan>,
    (mut batches, scene): (ResMut<MeshBatches>, Res<ExtractedScene>),
    (materials, tiles): (Res<MaterialRecords>, Res<Tiles>),
    buffers: Option<Res<VolumeBuffers>>,
    uniforms: Res<VolumeUniforms>,
    (groups, queue): (BindGroups, Res<RenderQueue>),
) {
    pass.work = None;
    let (Some(true), Some(buffers), Some(volume), Some(records)) = (
        plan.work.map(|work| work.voxelizes),
        buffers,
        uniforms.bounces[0].binding(),
        materials.view(),
    ) else {
        return;
    };
    let [occupancy_layout, surfaces_layout] = &pass.voxels_layouts;
    let voxels = |layout, own, buffer, slots| {
        let entries = ((VOLUME, volume.clone()), (own, buffer), (FACE_SLOTS, slots));
        groups.create(layout, entries)
    };
    let [sums, all] = [&buffers.sums, &buffers.voxels].map(|buffer| buffer.as_entire_binding());
    let voxels = [
        voxels(
            occupancy_layout,
            MASKS,
            buffers.masks(),
            buffers.face_slots(),
        ),
        // The masks follow behind the slots.
        voxels(surfaces_layout, SUMS, sums, all),
    ];
    let resolve = groups.create(
        &pass.resolve_layout,
        (
            (VOLUME, volume.clone()),
            (MASKS, buffers.masks()),
            (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
            (FACE_SLOTS, buffers.face_slots()),
            (SUMS, buffers.sums.as_entire_binding()),
        ),
    );
    // Without textures, no shader reads the tiles.
    let tiles = tiles.view().unwrap_or(records);
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
                records,
                tiles,
            )),
        );
        Some((bind_group, batch_count))
    };
    let groups = batches.groups_mut().filter_map(bind).collect();
    pass.work = Some(VoxelizeWork {
        voxels,
        resolve,
        groups,
    });
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
    let (Some([occupancy, surfaces]), Some(resolve)) =
        (kernels.pipelines(&cache), pass.resolve.pipeline(&cache))
    else {
        return;
    };
    let encoder = context.command_encoder();
    keep_slots(encoder, &buffers);
    encoder.clear_buffer(&buffers.voxels, 0, None);
    encoder.clear_buffer(&buffers.work, 0, Some(VolumeBuffers::COUNTERS_SIZE));
    if frame.moves.is_some() {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
        encoder.clear_buffer(&buffers.visible, 0, None);
    }
    let visible = pass.visible.pipelines(&cache);
    let [masks, sums] = &work.voxels;
    record_pass(&mut context, "voxel_gi_voxelize", |compute| {
        work.record(compute, occupancy, masks);
        if let Some([occupancy, _]) = visible {
            pass.visible.record(compute, occupancy, masks, &buffers);
        }
        allocate.record(compute, &buffers, &cache);
    });
    context
        .command_encoder()
        .clear_buffer(&buffers.sums, 0, None);
    record_pass(&mut context, "voxel_gi_surfaces", |compute| {
        work.record(compute, surfaces, sums);
        if let Some([_, surfaces]) = visible {
            pass.visible.record(compute, surfaces, sums, &buffers);
        }
        compute.set_bind_group(0, &work.resolve, &[]);
        dispatch_voxels(compute, resolve, &buffers);
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
    embedded_asset!(app, "resolve.wesl");
    visible::embed(app);
}

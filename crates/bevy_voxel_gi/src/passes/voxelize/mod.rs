//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5), where something has changed: voxels are cleared, and
//! triangles that reach into them are found. Then come two passes over these: occupancy and the faces that have a
//! surface, then the areas and colours of the surfaces, whose sums are resolved last.

mod clear;
mod cull;
mod kernels;
mod scatter;
mod visible;

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferDescriptor, BufferUsages, ComputePass, ComputePipeline, PipelineCache,
            RawBufferVec, ShaderStages, TextureSampleType, binding_types::texture_2d,
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
    kernel::{Kernel, dispatch_voxels, record_pass},
    read_back::CountsCopy,
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
        voxelization::Voxelization,
    },
    settings::Voxelizer,
};
use clear::ClearPass;
use cull::CullPass;
use kernels::Kernels;
use scatter::ScatterPass;
use visible::VisibleVoxels;

#[derive(Resource)]
pub(crate) struct VoxelizePass {
    /// Layouts of the volume's buffers, which the voxelisers write in their two passes.
    voxels_layouts: [BindGroupLayoutDescriptor; 2],
    /// Layout of the buffers of a group of meshes, which the voxelisers read.
    meshes_layout: BindGroupLayoutDescriptor,
    scatter: ScatterPass,
    clear: ClearPass,
    cull: CullPass,
    conservative: Kernels,
    slices: Kernels,
    points: Kernels,
    visible: VisibleVoxels,
    resolve_layout: BindGroupLayoutDescriptor,
    resolve: Kernel,
    share_layout: BindGroupLayoutDescriptor,
    /// Where something emits.
    share_emission: Kernel,
    emits: bool,
    /// Matrices of joints and weights of morph targets.
    joints: RawBufferVec<Mat4>,
    work: Option<VoxelizeWork>,
}

/// The bind groups of a frame that voxelises.
struct VoxelizeWork {
    voxels: [BindGroup; 2],
    resolve: BindGroup,
    share_emission: BindGroup,
    groups: Vec<BindGroup>,
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
            (PACKED_SURFACES, read_write()),
            (FACE_SLOTS, read_write()),
            (SUMS, read_write()),
        ),
    );
    let share_layout = group_layout(
        "voxel_gi_share_emission",
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
    let resolve = |label, entry_point, layout: &BindGroupLayoutDescriptor| {
        let shader = load_embedded_asset!(assets, "resolve.wesl");
        Kernel::new(label, entry_point, &shader, vec![layout.clone()])
    };
    commands.insert_resource(VoxelizePass {
        scatter: ScatterPass::new(assets),
        clear: ClearPass::new(assets),
        cull: CullPass::new(assets),
        conservative: kernels(load_embedded_asset!(assets, "conservative.wesl")),
        slices: kernels(load_embedded_asset!(assets, "slices.wesl")),
        points: kernels(load_embedded_asset!(assets, "points.wesl")),
        visible: VisibleVoxels::new(&voxels_layouts, assets),
        resolve: resolve("voxel_gi_resolve", "resolve", &resolve_layout),
        share_emission: resolve("voxel_gi_share_emission", "share_emission", &share_layout),
        emits: false,
        resolve_layout,
        share_layout,
        voxels_layouts,
        meshes_layout,
        joints: RawBufferVec::new(BufferUsages::STORAGE),
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
    pass.emits = emission.is_some();
    if pass.emits {
        pass.share_emission.require(&[], &cache, &mut required);
    }
    pass.scatter.queue(&cache, &mut required);
    pass.clear.queue(shadow_masks, &cache, &mut required);
    pass.cull.queue(&cache, &mut required);
    if shape.marks_visible {
        pass.visible.queue(shadow_masks, &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<VoxelizePass>,
    plan: Res<FramePlan>,
    (mut batches, mut scene): (ResMut<MeshBatches>, ResMut<ExtractedScene>),
    (materials, tiles): (Res<MaterialRecords>, Res<Tiles>),
    buffers: Option<Res<VolumeBuffers>>,
    (uniforms, volume): (Res<VolumeUniforms>, Res<ExtractedVolume>),
    (groups, queue): (BindGroups, Res<RenderQueue>),
) {
    let pass = &mut *pass;
    pass.work = None;
    let Some(placed) = &volume.0 else {
        return;
    };
    let (Some(_), Some(buffers), Some(volume), Some(records)) = (
        plan.work.and_then(|work| work.voxelizes),
        buffers,
        uniforms.bounces[0].binding(),
        materials.view(),
    ) else {
        return;
    };
    let levels = placed.levels.len() as u32;
    let levels = levels * (1 + u32::from(buffers.has_shadow_masks()));
    let rows = [placed.settings.resolution, levels];
    let clear = pass.clear.prepare(rows, &buffers, &uniforms, &groups);
    if clear.and(pass.cull.begin(&uniforms, &groups)).is_none() {
        return;
    }
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
            (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
            (FACE_SLOTS, buffers.face_slots()),
            (SUMS, buffers.sums.as_entire_binding()),
        ),
    );
    let share_emission = groups.create(
        &pass.share_layout,
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
    let device = &groups.device;
    let stub = device.create_buffer(&BufferDescriptor {
        label: Some("voxel_gi_none"),
        size: 16,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    // The next frame extracts them anew.
    std::mem::swap(pass.joints.values_mut(), &mut scene.joints);
    if pass.joints.is_empty() {
        pass.joints.push(Mat4::IDENTITY);
    }
    pass.joints.write_buffer(device, &queue);
    let layout = groups.cache.get_bind_group_layout(&pass.meshes_layout);
    let volume_buffers = &*buffers;
    pass.scatter.begin();
    let bind = |group: &mut MeshGroup| {
        let buffers = group.buffers.each_ref();
        let buffers = buffers.map(|buffer| buffer.clone().unwrap_or_else(|| stub.clone()));
        let [vertices, indices, morph_targets] = &buffers;
        let uploaded = group.upload(device, &queue)?;
        pass.scatter.add(&uploaded.instances, &groups);
        pass.scatter.add(&uploaded.batches, &groups);
        pass.cull.add(&buffers, &uploaded, volume_buffers, &groups);
        let bind_group = device.create_bind_group(
            "voxel_gi_voxelize_meshes",
            &layout,
            &BindGroupEntries::sequential((
                vertices.as_entire_binding(),
                indices.as_entire_binding(),
                uploaded.instances.items,
                uploaded.items.as_entire_binding(),
                pass.joints.binding()?,
                morph_targets.as_entire_binding(),
                records,
                tiles,
            )),
        );
        Some(bind_group)
    };
    let bind_groups = batches.groups_mut().filter_map(bind).collect();
    pass.cull.finish(device);
    pass.work = Some(VoxelizeWork {
        voxels,
        resolve,
        share_emission,
        groups: bind_groups,
    });
}

impl VoxelizeWork {
    /// Records one of the two passes over all meshes.
    fn record(
        &self,
        pass: &mut ComputePass<'_>,
        pipeline: &ComputePipeline,
        voxels: &BindGroup,
        cull: &CullPass,
    ) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, voxels, &[]);
        for (i, bind_group) in self.groups.iter().enumerate() {
            pass.set_bind_group(1, bind_group, &[]);
            cull.dispatch(pass, i);
        }
    }
}

/// Voxelises the scene where it has changed.
pub(crate) fn voxelize(
    mut context: RenderContext,
    (pass, allocate): (Res<VoxelizePass>, Res<AllocatePass>),
    mut counts: ResMut<CountsCopy>,
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
    let Some(voxelizes) = frame.voxelizes else {
        return;
    };
    let encoder = context.command_encoder();
    keep_slots(encoder, &buffers);
    if voxelizes == Voxelization::Whole {
        encoder.clear_buffer(&buffers.slot_lists, 0, None);
    }
    pass.cull.clear_counts(encoder);
    if frame.has_moved {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
        encoder.clear_buffer(&buffers.visible, 0, None);
    }
    let visible = pass.visible.pipelines(&cache);
    let [masks, sums] = &work.voxels;
    record_pass(&mut context, "voxel_gi_clear", |compute| {
        pass.scatter.record(compute, &cache);
        pass.clear.record(compute, voxelizes, &buffers, &cache);
        pass.cull.record(compute, &cache);
    });
    pass.cull.copy_args(context.command_encoder());
    record_pass(&mut context, "voxel_gi_voxelize", |compute| {
        work.record(compute, occupancy, masks, &pass.cull);
        if let Some([occupancy, _]) = visible {
            pass.visible.record(compute, occupancy, masks, &buffers);
        }
        allocate.record(compute, &buffers, &cache);
    });
    // The sums of areas and emission; those of albedo are cleared where slots are allocated.
    let bytes = buffers.irradiance.size();
    let encoder = context.command_encoder();
    encoder.clear_buffer(&buffers.sums, 0, Some(bytes));
    record_pass(&mut context, "voxel_gi_surfaces", |compute| {
        work.record(compute, surfaces, sums, &pass.cull);
        if let Some([_, surfaces]) = visible {
            pass.visible.record(compute, surfaces, sums, &buffers);
        }
        compute.set_bind_group(0, &work.resolve, &[]);
        dispatch_voxels(compute, resolve, &buffers);
        if let Some(share_emission) = pass.share_emission.pipeline(&cache).filter(|_| pass.emits) {
            compute.set_bind_group(0, &work.share_emission, &[]);
            dispatch_voxels(compute, share_emission, &buffers);
        }
    });
    if frame.has_changed {
        pass.visible.clear(context.command_encoder(), &buffers);
    }
    let is_whole = voxelizes == Voxelization::Whole;
    let encoder = context.command_encoder();
    counts.record(encoder, &buffers, pass.cull.counts(), is_whole, &device);
}

pub(crate) fn embed(app: &mut App) {
    clear::embed(app);
    cull::embed(app);
    scatter::embed(app);
    embedded_asset!(app, "conservative.wesl");
    embedded_asset!(app, "slices.wesl");
    embedded_asset!(app, "points.wesl");
    embedded_asset!(app, "resolve.wesl");
    visible::embed(app);
}

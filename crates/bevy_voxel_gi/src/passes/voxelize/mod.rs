//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5), where something has changed: voxels are cleared or moved
//! with their levels, and triangles that reach into the cleared ones are found. Then come two passes over these: occupancy
//! and the faces that have a surface, to which slots are allocated; then the areas and colours of the surfaces, whose sums
//! are resolved last.

mod meshes;

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferUsages, ComputePass, ComputePipeline, PipelineCache, RawBufferVec, ShaderStages,
            TextureSampleType, binding_types::texture_2d,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use super::{
    bindings::{Access::Read, BindGroups, Binding::*, Group, storage},
    kernel::{Kernel, Pipelines, dispatch_voxels, record_pass, set_bind_groups},
};
use crate::{
    extract::{meshes::ExtractedScene, place_volume::ExtractedVolume},
    prepare::{
        buffers::{BufferShape, CountsCopy, ShadowMasks, VolumeBuffers, buffer},
        materials::{EMISSION, MaterialRecords},
        mesh_batches::MeshBatches,
        mesh_group::MeshGroup,
        plan::FramePlan,
        tiles::Tiles,
        voxelization::Voxelization,
    },
    settings::Voxelizer,
};
use meshes::{CullPass, ScatterPass};

#[derive(Resource)]
pub(crate) struct VoxelizePass {
    scatter: ScatterPass,
    cull: CullPass,
    clear_groups: [Group; 2],
    clear: Kernel,
    /// Moves masks along each axis.
    moves: [Kernel; 3],
    /// The volume's buffers, which the voxelisers write in their two passes.
    voxels_groups: [Group; 2],
    /// Layout of the buffers of a group of meshes, which the voxelisers read.
    meshes_layout: BindGroupLayoutDescriptor,
    /// Conservative, by slices, and by points.
    voxelizers: [Kernels; 3],
    /// The pass that adds the points that cameras saw; `cameras` marks them.
    visible_group: Group,
    visible: Kernels,
    allocate_groups: [Group; 2],
    allocate: Kernel,
    resolve_group: Group,
    resolve: Kernel,
    share_group: Group,
    /// Where something emits.
    share_emission: Kernel,
    emits: bool,
    /// Matrices of joints and weights of morph targets.
    joints: RawBufferVec<Mat4>,
    work: Option<VoxelizeWork>,
}

/// The bind groups of a frame that voxelises.
struct VoxelizeWork {
    clear: [BindGroup; 2],
    /// Rows of masks along both other edges of a level, and the number of levels, of which those of meshes that shadow
    /// direct light count, too.
    rows: [u32; 3],
    voxels: [BindGroup; 2],
    meshes: Vec<BindGroup>,
    /// The group is there if the volume voxelises the points that cameras saw.
    visible: Option<BindGroup>,
    allocate: [BindGroup; 2],
    resolve: BindGroup,
    share_emission: BindGroup,
}

/// The kernels of the two passes of a voxeliser.
struct Kernels {
    /// Marks occupied sub-voxels, and the faces with a surface.
    occupancy: Kernel,
    /// Writes the surfaces, once the faces have slots.
    surfaces: Kernel,
}

impl Kernels {
    /// `labels` and `voxels` are of the two passes, `source` is the layout of what both read.
    fn new(
        labels: [&'static str; 2],
        shader: &Handle<Shader>,
        voxels: &[Group; 2],
        source: &BindGroupLayoutDescriptor,
    ) -> Self {
        let kernel = |pass: usize| {
            let layouts = [&voxels[pass].layout, source];
            Kernel::new(labels[pass], "voxelize", shader, &layouts)
        };
        Self {
            occupancy: kernel(0),
            surfaces: kernel(1),
        }
    }

    /// Chooses the variants of the two passes with these shader defs for this frame, which waits until they are ready.
    fn require(
        &mut self,
        [of_occupancy, of_surfaces]: [&[&'static str]; 2],
        pipelines: &mut Pipelines,
    ) {
        self.occupancy.require(of_occupancy, pipelines);
        let of_surfaces = [of_surfaces, &["SURFACES"]].concat();
        self.surfaces.require(&of_surfaces, pipelines);
    }

    fn pipelines<'a>(&self, cache: &'a PipelineCache) -> Option<[&'a ComputePipeline; 2]> {
        let surfaces = self.surfaces.pipeline(cache)?;
        Some([self.occupancy.pipeline(cache)?, surfaces])
    }
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let clear_groups = [
        Group::new(
            "voxel_gi_clear_volume",
            &[Volume(0)],
            &[Masks, PackedSurfaces, FaceSlots],
        ),
        Group::new("voxel_gi_clear", &[Changes, Dirty], &[SlotLists]),
    ];
    let voxels_groups = [
        Group::new(
            "voxel_gi_voxelize_volume",
            &[Volume(0)],
            &[Masks, FaceSlots],
        ),
        Group::new(
            "voxel_gi_surfaces_volume",
            &[Volume(0)],
            &[Sums, FaceSlotsAndMasks],
        ),
    ];
    let integers = || texture_2d(TextureSampleType::Uint);
    let meshes_layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_voxelize_meshes",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                storage(Read),
                storage(Read),
                storage(Read),
                storage(Read),
                storage(Read),
                storage(Read),
                integers(),
                integers(),
            ),
        ),
    );
    let visible_group = Group::new("voxel_gi_visible", &[Visible], &[]);
    let slots = [PackedSurfaces, FaceSlots, Sums];
    let allocate_groups = [
        Group::new("voxel_gi_allocate_volume", &[Volume(0)], &slots),
        Group::new(
            "voxel_gi_allocate",
            &[Changes, Dirty],
            &[Irradiance, SlotLists],
        ),
    ];
    let resolve_group = Group::new("voxel_gi_resolve", &[Volume(0)], &slots);
    let share_group = Group::new(
        "voxel_gi_share_emission",
        &[Volume(0), Masks, FaceSlots],
        &[PackedSurfaces, Sums],
    );
    let clear = load_embedded_asset!(assets, "clear.wesl");
    let clear = |label, entry_point| {
        let [voxels, own] = &clear_groups;
        Kernel::new(label, entry_point, &clear, &[&voxels.layout, &own.layout])
    };
    let kernels = |shader: Handle<Shader>| {
        let labels = ["voxel_gi_voxelize", "voxel_gi_surfaces"];
        Kernels::new(labels, &shader, &voxels_groups, &meshes_layout)
    };
    let visible = load_embedded_asset!(assets, "visible.wesl");
    let labels = ["voxel_gi_visible", "voxel_gi_visible_surfaces"];
    let allocate = load_embedded_asset!(assets, "allocate.wesl");
    let layouts = allocate_groups.each_ref().map(|group| &group.layout);
    let resolve = load_embedded_asset!(assets, "resolve.wesl");
    let resolve = |label, entry_point, group: &Group| {
        Kernel::new(label, entry_point, &resolve, &[&group.layout])
    };
    commands.insert_resource(VoxelizePass {
        scatter: ScatterPass::new(assets),
        cull: CullPass::new(assets),
        clear: clear("voxel_gi_clear", "clear"),
        moves: ["move_along_x", "move_along_y", "move_along_z"]
            .map(|entry_point| clear("voxel_gi_move", entry_point)),
        voxelizers: [
            kernels(load_embedded_asset!(assets, "conservative.wesl")),
            kernels(load_embedded_asset!(assets, "slices.wesl")),
            kernels(load_embedded_asset!(assets, "points.wesl")),
        ],
        visible: Kernels::new(labels, &visible, &voxels_groups, &visible_group.layout),
        allocate: Kernel::new("voxel_gi_allocate", "allocate", &allocate, &layouts),
        resolve: resolve("voxel_gi_resolve", "resolve", &resolve_group),
        share_emission: resolve("voxel_gi_share_emission", "share_emission", &share_group),
        emits: false,
        clear_groups,
        voxels_groups,
        meshes_layout,
        visible_group,
        allocate_groups,
        resolve_group,
        share_group,
        joints: RawBufferVec::new(BufferUsages::STORAGE),
        work: None,
    });
}

/// The index of a voxeliser in [`VoxelizePass::voxelizers`].
fn number_of(voxelizer: Voxelizer) -> usize {
    match voxelizer {
        Voxelizer::Conservative => 0,
        Voxelizer::FragmentClipping | Voxelizer::GeometryClipping => 1,
        Voxelizer::Stochastic { .. } => 2,
    }
}

pub(crate) fn queue(
    mut pass: ResMut<VoxelizePass>,
    (volume, materials): (Res<ExtractedVolume>, Res<MaterialRecords>),
    shadow_masks: ShadowMasks,
    mut pipelines: Pipelines,
) {
    let Some(volume) = &volume.0 else {
        return;
    };
    let pass = &mut *pass;
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
    let kernels = &mut pass.voxelizers[number_of(voxelizer)];
    kernels.require(defs.each_ref().map(Vec::as_slice), &mut pipelines);
    let emission = (materials.emission_unit > 0.0).then_some(EMISSION);
    pass.resolve.require(emission.as_slice(), &mut pipelines);
    pass.emits = emission.is_some();
    if pass.emits {
        pass.share_emission.require(&[], &mut pipelines);
    }
    pass.scatter.queue(&mut pipelines);
    for kernel in pass.moves.iter_mut().chain([&mut pass.clear]) {
        kernel.require(shadow_masks.as_slice(), &mut pipelines);
    }
    pass.cull.queue(&mut pipelines);
    if shape.marks_visible {
        let defs = [shadow_masks.as_slice(), &[]];
        pass.visible.require(defs, &mut pipelines);
    }
    pass.allocate.require(&[], &mut pipelines);
}

pub(crate) fn prepare(
    mut pass: ResMut<VoxelizePass>,
    plan: Res<FramePlan>,
    (mut batches, mut scene): (ResMut<MeshBatches>, ResMut<ExtractedScene>),
    (materials, tiles): (Res<MaterialRecords>, Res<Tiles>),
    (groups, queue): (BindGroups, Res<RenderQueue>),
) {
    let pass = &mut *pass;
    pass.work = None;
    let (Some(_), Some(buffers), Some(placed), Some(records)) = (
        plan.work.and_then(|work| work.voxelizes),
        &groups.buffers,
        &groups.volume.0,
        materials.view(),
    ) else {
        return;
    };
    let (Some(clear), Some(voxels), Some(allocate), Some(resolve), Some(share_emission)) = (
        groups.bind_both(&pass.clear_groups),
        groups.bind_both(&pass.voxels_groups),
        groups.bind_both(&pass.allocate_groups),
        groups.bind(&pass.resolve_group),
        groups.bind(&pass.share_group),
    ) else {
        return;
    };
    if pass.cull.begin(&groups).is_none() {
        return;
    }
    let levels = placed.levels.len() as u32;
    let levels = levels * (1 + u32::from(buffers.has_shadow_masks()));
    let rows = placed.settings.resolution;
    let visible = if buffers.shape.marks_visible {
        groups.bind(&pass.visible_group)
    } else {
        None
    };
    // Without textures, no shader reads the tiles.
    let tiles = tiles.view().unwrap_or(records);
    let device = &groups.device;
    let stub = buffer(device, "voxel_gi_none", 16, BufferUsages::STORAGE);
    // The next frame extracts them anew.
    std::mem::swap(pass.joints.values_mut(), &mut scene.joints);
    if pass.joints.is_empty() {
        pass.joints.push(Mat4::IDENTITY);
    }
    pass.joints.write_buffer(device, &queue);
    pass.scatter.begin();
    let bind = |group: &mut MeshGroup| {
        let buffers = group.buffers.each_ref();
        let buffers = buffers.map(|buffer| buffer.clone().unwrap_or_else(|| stub.clone()));
        let [vertices, indices, morph_targets] = &buffers;
        let uploaded = group.upload(device, &queue)?;
        pass.scatter.add(&uploaded.instances, &groups);
        pass.scatter.add(&uploaded.batches, &groups);
        pass.cull.add(&buffers, &uploaded, &groups);
        let entries = BindGroupEntries::sequential((
            vertices.as_entire_binding(),
            indices.as_entire_binding(),
            uploaded.instances.items,
            uploaded.items.as_entire_binding(),
            pass.joints.binding()?,
            morph_targets.as_entire_binding(),
            records,
            tiles,
        ));
        Some(groups.create(&pass.meshes_layout, &entries))
    };
    let meshes = batches.groups_mut().filter_map(bind).collect();
    pass.cull.finish(device);
    pass.work = Some(VoxelizeWork {
        clear,
        rows: [rows, rows, levels],
        voxels,
        meshes,
        visible,
        allocate,
        resolve,
        share_emission,
    });
}

pub(crate) fn voxelize(
    mut context: RenderContext,
    pass: Res<VoxelizePass>,
    mut counts: ResMut<CountsCopy>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
) {
    let (Some(frame), Some(volume), Some(buffers)) = (plan.work, &volume.0, buffers) else {
        return;
    };
    let kernels = &pass.voxelizers[number_of(volume.settings.voxelizer)];
    let (
        Some(work),
        Some(voxelizes),
        Some([occupancy, surfaces]),
        Some(clear),
        Some(allocate),
        Some(resolve),
    ) = (
        &pass.work,
        frame.voxelizes,
        kernels.pipelines(&cache),
        pass.clear.pipeline(&cache),
        pass.allocate.pipeline(&cache),
        pass.resolve.pipeline(&cache),
    )
    else {
        return;
    };
    let is_whole = voxelizes == Voxelization::Whole;
    let encoder = context.command_encoder();
    // The slots and their light as they are now, for `allocate.wesl`.
    let light = buffers.irradiance.size();
    encoder.copy_buffer_to_buffer(&buffers.irradiance, 0, &buffers.sums, 0, light);
    let (offset, words) = buffers.former_slot_words();
    encoder.copy_buffer_to_buffer(&buffers.voxels, 0, &buffers.work, offset, words);
    if is_whole {
        encoder.clear_buffer(&buffers.slot_lists, 0, None);
    }
    pass.cull.clear_counts(encoder);
    if frame.has_moved() {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
        encoder.clear_buffer(&buffers.visible, 0, None);
    }
    let visible = work.visible.as_ref();
    let visible = visible.zip(pass.visible.pipelines(&cache));
    // One of the two passes over all meshes, and over what cameras saw.
    let record = |compute: &mut ComputePass<'_>, number: usize, pipeline: &ComputePipeline| {
        compute.set_pipeline(pipeline);
        compute.set_bind_group(0, &work.voxels[number], &[]);
        for (i, meshes) in work.meshes.iter().enumerate() {
            compute.set_bind_group(1, meshes, &[]);
            pass.cull.dispatch(compute, i);
        }
        if let Some((group, pipelines)) = &visible {
            compute.set_bind_group(1, *group, &[]);
            dispatch_voxels(compute, pipelines[number], &buffers);
        }
    };
    record_pass(&mut context, "voxel_gi_clear", |compute| {
        pass.scatter.record(compute, &cache);
        set_bind_groups(compute, &work.clear);
        if let Voxelization::Part { moved } = voxelizes {
            let [x, y, z] = work.rows;
            let kernels = pass.moves.iter().enumerate();
            for (_, kernel) in kernels.filter(|(axis, _)| moved.test(*axis)) {
                if let Some(pipeline) = kernel.pipeline(&cache) {
                    compute.set_pipeline(pipeline);
                    compute.dispatch_workgroups(x, y, z);
                }
            }
        }
        dispatch_voxels(compute, clear, &buffers);
        pass.cull.record(compute, &cache);
    });
    pass.cull.copy_args(context.command_encoder());
    record_pass(&mut context, "voxel_gi_voxelize", |compute| {
        record(compute, 0, occupancy);
        set_bind_groups(compute, &work.allocate);
        dispatch_voxels(compute, allocate, &buffers);
    });
    // The sums of areas and emission; those of albedo are cleared where slots are allocated.
    let encoder = context.command_encoder();
    encoder.clear_buffer(&buffers.sums, 0, Some(light));
    record_pass(&mut context, "voxel_gi_surfaces", |compute| {
        record(compute, 1, surfaces);
        compute.set_bind_group(0, &work.resolve, &[]);
        dispatch_voxels(compute, resolve, &buffers);
        if let Some(share_emission) = pass.share_emission.pipeline(&cache).filter(|_| pass.emits) {
            compute.set_bind_group(0, &work.share_emission, &[]);
            dispatch_voxels(compute, share_emission, &buffers);
        }
    });
    let encoder = context.command_encoder();
    if frame.has_changed && work.visible.is_some() {
        // The marks of the frames before are not valid any more.
        encoder.clear_buffer(&buffers.visible, 0, None);
    }
    counts.record(encoder, &buffers, pass.cull.counts(), is_whole, &device);
}

//! Voxelisation: meshes to voxels (thesis sections 6.4 and 6.5).

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            BufferDescriptor, BufferUsages, PipelineCache, ShaderStages, StorageBuffer,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use super::{
    bindings::{MASKS, PACKED_SURFACES, VOLUME, read_only, read_write, volume_uniform},
    kernel::{Kernel, dispatch_workgroups, record_pass},
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

#[derive(Resource)]
pub(crate) struct VoxelizePass {
    /// Layout of the volume's buffers, which the voxelisers write.
    voxels_layout: BindGroupLayoutDescriptor,
    /// Layout of the buffers of a group of meshes, which the voxelisers read.
    meshes_layout: BindGroupLayoutDescriptor,
    conservative: Kernel,
    slices: Kernel,
    points: Kernel,
    work: Option<VoxelizeWork>,
}

/// The bind groups and dispatch sizes of a frame that voxelises.
struct VoxelizeWork {
    voxels: BindGroup,
    groups: Vec<(BindGroup, u32)>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let voxels_layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_voxelize_volume",
        &BindGroupLayoutEntries::with_indices(
            ShaderStages::COMPUTE,
            (
                (VOLUME, volume_uniform()),
                (MASKS, read_write()),
                (PACKED_SURFACES, read_write()),
            ),
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
    let kernel = |shader: Handle<Shader>| {
        let layout = vec![voxels_layout.clone(), meshes_layout.clone()];
        Kernel::new("voxel_gi_voxelize", "voxelize", &shader, layout)
    };
    commands.insert_resource(VoxelizePass {
        conservative: kernel(load_embedded_asset!(assets, "conservative.wesl")),
        slices: kernel(load_embedded_asset!(assets, "slices.wesl")),
        points: kernel(load_embedded_asset!(assets, "points.wesl")),
        voxels_layout,
        meshes_layout,
        work: None,
    });
}

impl VoxelizePass {
    fn kernel(&self, voxelizer: Voxelizer) -> &Kernel {
        match voxelizer {
            Voxelizer::Conservative => &self.conservative,
            Voxelizer::FragmentClipping | Voxelizer::GeometryClipping => &self.slices,
            Voxelizer::Stochastic { .. } => &self.points,
        }
    }

    fn kernel_mut(&mut self, voxelizer: Voxelizer) -> &mut Kernel {
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
    if BufferShape::of(volume).occlusion_only {
        defs.push("OCCLUSION_ONLY");
    }
    let voxelizer = volume.settings.voxelizer;
    if voxelizer == Voxelizer::GeometryClipping {
        defs.push("GEOMETRY_CLIPPING");
    }
    pass.kernel_mut(voxelizer)
        .require(&defs, &cache, &mut required);
}

pub(crate) fn prepare(
    mut pass: ResMut<VoxelizePass>,
    plan: Res<FramePlan>,
    (mut batches, scene): (ResMut<MeshBatches>, Res<ExtractedScene>),
    buffers: Option<Res<VolumeBuffers>>,
    uniforms: Res<VolumeUniforms>,
    (cache, device, queue): (Res<PipelineCache>, Res<RenderDevice>, Res<RenderQueue>),
) {
    pass.work = None;
    let (Some(_), Some(buffers), Some(volume)) =
        (plan.work, buffers, uniforms.bounces[0].binding())
    else {
        return;
    };
    let voxels = device.create_bind_group(
        "voxel_gi_voxelize_volume",
        &cache.get_bind_group_layout(&pass.voxels_layout),
        &BindGroupEntries::with_indices((
            (VOLUME, volume),
            (MASKS, buffers.masks.as_entire_binding()),
            (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
        )),
    );
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
    joints.write_buffer(&device, &queue);
    let layout = cache.get_bind_group_layout(&pass.meshes_layout);
    let bind = |group: &mut MeshGroup| {
        let lists = group.upload(&device, &queue)?;
        let buffers = group.buffers.each_ref();
        let [vertices, indices, morph_targets] =
            buffers.map(|buffer| buffer.as_ref().unwrap_or(&stub));
        let bind_group = device.create_bind_group(
            "voxel_gi_voxelize_meshes",
            &layout,
            &BindGroupEntries::sequential((
                vertices.as_entire_binding(),
                indices.as_entire_binding(),
                lists.instances.as_entire_binding(),
                lists.batches.as_entire_binding(),
                joints.binding()?,
                morph_targets.as_entire_binding(),
            )),
        );
        Some((bind_group, lists.batch_count))
    };
    pass.work = Some(VoxelizeWork {
        voxels,
        groups: batches.groups_mut().filter_map(bind).collect(),
    });
}

/// Clears the volume and voxelises the scene.
pub(crate) fn voxelize(
    mut context: RenderContext,
    pass: Res<VoxelizePass>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some(work), Some(frame), Some(volume), Some(buffers)) =
        (&pass.work, plan.work, &volume.0, buffers)
    else {
        return;
    };
    let Some(pipeline) = pass.kernel(volume.settings.voxelizer).pipeline(&cache) else {
        return;
    };
    let encoder = context.command_encoder();
    for buffer in [
        &buffers.masks,
        &buffers.packed_surfaces,
        &buffers.radiance,
        &buffers.counters,
    ] {
        encoder.clear_buffer(buffer, 0, None);
    }
    if frame.moves.is_some() {
        encoder.clear_buffer(&buffers.reprojected_albedo, 0, None);
    }
    record_pass(&mut context, "voxel_gi_voxelize", |pass| {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &work.voxels, &[]);
        for (bind_group, batches) in &work.groups {
            pass.set_bind_group(1, bind_group, &[]);
            dispatch_workgroups(pass, *batches);
        }
    });
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "conservative.wesl");
    embedded_asset!(app, "slices.wesl");
    embedded_asset!(app, "points.wesl");
}

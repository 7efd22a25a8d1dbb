//! The compute pipelines of the voxelisers.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId,
        ComputePipelineDescriptor, PipelineCache, ShaderStages, SpecializedComputePipeline,
        SpecializedComputePipelines,
        binding_types::{storage_buffer_read_only_sized, storage_buffer_sized, uniform_buffer},
    },
};

use crate::{settings::Voxelizer, volume::gpu::GpuVolume};

/// Selects the shader variant of a voxeliser's pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct VoxelizeKey {
    kind: Kind,
    /// Only ambient occlusion is computed, so only occupancy is stored.
    occlusion_only: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Conservative,
    FragmentClipping,
    GeometryClipping,
    Stochastic,
}

impl VoxelizeKey {
    pub(crate) fn new(voxelizer: Voxelizer, occlusion_only: bool) -> Self {
        let kind = match voxelizer {
            Voxelizer::Conservative => Kind::Conservative,
            Voxelizer::FragmentClipping => Kind::FragmentClipping,
            Voxelizer::GeometryClipping => Kind::GeometryClipping,
            Voxelizer::Stochastic { .. } => Kind::Stochastic,
        };
        Self {
            kind,
            occlusion_only,
        }
    }
}

#[derive(Resource)]
pub(crate) struct VoxelizePipeline {
    /// Layout of the volume's buffers, which the voxelisers write.
    pub volume: BindGroupLayoutDescriptor,
    /// Layout of the buffers of a group of meshes, which the voxelisers read.
    pub group: BindGroupLayoutDescriptor,
    conservative: Handle<Shader>,
    slices: Handle<Shader>,
    points: Handle<Shader>,
}

pub(crate) fn init_pipeline(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let read = || storage_buffer_read_only_sized(false, None);
    let write = || storage_buffer_sized(false, None);
    commands.insert_resource(VoxelizePipeline {
        volume: BindGroupLayoutDescriptor::new(
            "voxel_gi_voxelize_volume",
            &BindGroupLayoutEntries::sequential(
                ShaderStages::COMPUTE,
                (uniform_buffer::<GpuVolume>(false), write(), write()),
            ),
        ),
        group: BindGroupLayoutDescriptor::new(
            "voxel_gi_voxelize_meshes",
            &BindGroupLayoutEntries::sequential(
                ShaderStages::COMPUTE,
                (read(), read(), read(), read(), read(), read()),
            ),
        ),
        conservative: load_embedded_asset!(assets, "conservative.wesl"),
        slices: load_embedded_asset!(assets, "slices.wesl"),
        points: load_embedded_asset!(assets, "points.wesl"),
    });
}

impl SpecializedComputePipeline for VoxelizePipeline {
    type Key = VoxelizeKey;

    fn specialize(&self, key: Self::Key) -> ComputePipelineDescriptor {
        let mut shader_defs = Vec::new();
        if key.occlusion_only {
            shader_defs.push("OCCLUSION_ONLY".into());
        }
        if key.kind == Kind::GeometryClipping {
            shader_defs.push("GEOMETRY_CLIPPING".into());
        }
        ComputePipelineDescriptor {
            label: Some("voxel_gi_voxelize".into()),
            layout: vec![self.volume.clone(), self.group.clone()],
            shader: match key.kind {
                Kind::Conservative => &self.conservative,
                Kind::FragmentClipping | Kind::GeometryClipping => &self.slices,
                Kind::Stochastic => &self.points,
            }
            .clone(),
            shader_defs,
            entry_point: Some("voxelize".into()),
            ..default()
        }
    }
}

/// Returns the pipeline of a voxeliser.
pub(crate) fn pipeline_for(
    key: VoxelizeKey,
    pipeline: &VoxelizePipeline,
    pipelines: &mut SpecializedComputePipelines<VoxelizePipeline>,
    cache: &PipelineCache,
) -> CachedComputePipelineId {
    pipelines.specialize(cache, pipeline, key)
}

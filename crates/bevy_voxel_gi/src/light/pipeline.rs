//! The compute pipelines of light transport.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId,
        ComputePipelineDescriptor, PipelineCache, ShaderStages, SpecializedComputePipeline,
        SpecializedComputePipelines, StorageTextureAccess, TextureFormat,
        binding_types::{
            storage_buffer_read_only_sized, storage_buffer_sized, texture_storage_3d,
            uniform_buffer,
        },
    },
};

use crate::volume::gpu::{BufferShape, GpuVolume};

/// A compute pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Pass {
    Compact,
    WriteIndirectArgs,
    Inject,
    Gather,
    GatherEmpty,
    Seed,
    Propagate,
    Deposit,
}

/// Selects the shader variant of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LightKey {
    pass: Pass,
    occlusion_only: bool,
    reprojects_albedo: bool,
    per_pixel: bool,
}

#[derive(Resource)]
pub(crate) struct LightPipelines {
    /// Layout of the group that all passes share: the uniforms and the voxels.
    pub volume: BindGroupLayoutDescriptor,
    pub compact: BindGroupLayoutDescriptor,
    pub inject: BindGroupLayoutDescriptor,
    pub gather: BindGroupLayoutDescriptor,
    pub propagate: BindGroupLayoutDescriptor,
    compact_shader: Handle<Shader>,
    inject_shader: Handle<Shader>,
    gather_shader: Handle<Shader>,
    propagate_shader: Handle<Shader>,
}

/// The pipelines of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightPipelineIds {
    pub compact: CachedComputePipelineId,
    pub write_indirect_args: CachedComputePipelineId,
    /// `None` if only ambient occlusion is computed.
    pub inject: Option<CachedComputePipelineId>,
    pub solver: SolverIds,
}

/// The pipelines of the solver.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SolverIds {
    Trace {
        surfaces: CachedComputePipelineId,
        empty: CachedComputePipelineId,
    },
    Propagate {
        seed: CachedComputePipelineId,
        step: CachedComputePipelineId,
        deposit: CachedComputePipelineId,
    },
}

impl LightPipelineIds {
    pub(crate) fn are_ready(&self, cache: &PipelineCache) -> bool {
        let solver = match self.solver {
            SolverIds::Trace { surfaces, empty } => vec![surfaces, empty],
            SolverIds::Propagate {
                seed,
                step,
                deposit,
            } => vec![seed, step, deposit],
        };
        [self.compact, self.write_indirect_args]
            .into_iter()
            .chain(self.inject)
            .chain(solver)
            .all(|id| cache.get_compute_pipeline(id).is_some())
    }
}

pub(crate) fn init_pipelines(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let read = || storage_buffer_read_only_sized(false, None);
    let write = || storage_buffer_sized(false, None);
    let texture =
        || texture_storage_3d(TextureFormat::Rgba16Float, StorageTextureAccess::WriteOnly);
    let compute = ShaderStages::COMPUTE;
    commands.insert_resource(LightPipelines {
        volume: BindGroupLayoutDescriptor::new(
            "voxel_gi_volume",
            &BindGroupLayoutEntries::sequential(
                compute,
                (uniform_buffer::<GpuVolume>(false), read(), read(), read()),
            ),
        ),
        compact: BindGroupLayoutDescriptor::new(
            "voxel_gi_compact",
            &BindGroupLayoutEntries::sequential(compute, (write(), write(), texture(), write())),
        ),
        inject: BindGroupLayoutDescriptor::new(
            "voxel_gi_inject",
            &BindGroupLayoutEntries::sequential(
                compute,
                (read(), read(), write(), read(), read(), read()),
            ),
        ),
        gather: BindGroupLayoutDescriptor::new(
            "voxel_gi_gather",
            &BindGroupLayoutEntries::sequential(
                compute,
                (read(), read(), read(), texture(), write()),
            ),
        ),
        propagate: BindGroupLayoutDescriptor::new(
            "voxel_gi_propagate",
            &BindGroupLayoutEntries::sequential(
                compute,
                (read(), read(), read(), write(), write(), texture()),
            ),
        ),
        compact_shader: load_embedded_asset!(assets, "compact.wesl"),
        inject_shader: load_embedded_asset!(assets, "inject.wesl"),
        gather_shader: load_embedded_asset!(assets, "gather.wesl"),
        propagate_shader: load_embedded_asset!(assets, "propagate.wesl"),
    });
}

impl LightPipelines {
    pub(crate) fn ids(
        &self,
        shape: BufferShape,
        pipelines: &mut SpecializedComputePipelines<Self>,
        cache: &PipelineCache,
    ) -> LightPipelineIds {
        let mut id = |pass| {
            let key = LightKey {
                pass,
                occlusion_only: shape.occlusion_only,
                reprojects_albedo: shape.reprojects_albedo,
                per_pixel: shape.per_pixel,
            };
            pipelines.specialize(cache, self, key)
        };
        LightPipelineIds {
            compact: id(Pass::Compact),
            write_indirect_args: id(Pass::WriteIndirectArgs),
            inject: (!shape.occlusion_only).then(|| id(Pass::Inject)),
            solver: if shape.propagates {
                SolverIds::Propagate {
                    seed: id(Pass::Seed),
                    step: id(Pass::Propagate),
                    deposit: id(Pass::Deposit),
                }
            } else {
                SolverIds::Trace {
                    surfaces: id(Pass::Gather),
                    empty: id(Pass::GatherEmpty),
                }
            },
        }
    }
}

impl SpecializedComputePipeline for LightPipelines {
    type Key = LightKey;

    fn specialize(&self, key: Self::Key) -> ComputePipelineDescriptor {
        let (label, entry_point, shader, layout) = match key.pass {
            Pass::Compact => (
                "voxel_gi_compact",
                "compact",
                &self.compact_shader,
                &self.compact,
            ),
            Pass::WriteIndirectArgs => (
                "voxel_gi_write_indirect_args",
                "write_indirect_args",
                &self.compact_shader,
                &self.compact,
            ),
            Pass::Inject => (
                "voxel_gi_inject",
                "inject",
                &self.inject_shader,
                &self.inject,
            ),
            Pass::Gather => (
                "voxel_gi_gather",
                "gather",
                &self.gather_shader,
                &self.gather,
            ),
            Pass::GatherEmpty => (
                "voxel_gi_gather_empty",
                "gather_empty",
                &self.gather_shader,
                &self.gather,
            ),
            Pass::Seed => (
                "voxel_gi_seed",
                "seed",
                &self.propagate_shader,
                &self.propagate,
            ),
            Pass::Propagate => (
                "voxel_gi_propagate",
                "propagate",
                &self.propagate_shader,
                &self.propagate,
            ),
            Pass::Deposit => (
                "voxel_gi_deposit",
                "deposit",
                &self.propagate_shader,
                &self.propagate,
            ),
        };
        ComputePipelineDescriptor {
            label: Some(label.into()),
            layout: vec![self.volume.clone(), layout.clone()],
            shader: shader.clone(),
            shader_defs: [
                (key.occlusion_only, "OCCLUSION_ONLY"),
                (key.reprojects_albedo, "REPROJECTED_ALBEDO"),
                (key.per_pixel, "PER_PIXEL"),
            ]
            .into_iter()
            .filter(|(on, _)| *on)
            .map(|(_, def)| def.into())
            .collect(),
            entry_point: Some(entry_point.into()),
            zero_initialize_workgroup_memory: true,
            ..default()
        }
    }
}

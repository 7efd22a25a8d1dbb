//! Computes the light: the surfaces and the empty voxels are compacted, so that there is one workgroup for each; then
//! come direct light and ray tracing of each bounce, or all steps of propagation.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::{
        render_resource::{BindGroup, ComputePass, PipelineCache},
        renderer::RenderContext,
    },
};

use super::{
    bindings::{BindGroups, Binding::*, Group, VoxelBindGroups},
    draw_sky::{SKY_MAP_DEF, SkyCube},
    kernel::{Kernel, Pipelines, dispatch_voxels, light_defs, record_pass},
};
use crate::{
    extract::{lights::ExtractedLights, place_volume::ExtractedVolume},
    prepare::{
        buffers::{BufferShape, ShadowMasks, VolumeBuffers},
        plan::{FramePlan, FrameWork},
        uniforms::uniform_of,
    },
};

#[derive(Resource)]
pub(crate) struct SolvePass {
    /// Compaction, which also writes what pixels read of new voxels beside their light.
    compact_group: Group,
    compact: Kernel,
    write_indirect_args: Kernel,
    write_geometry: Kernel,
    /// Direct light on the surfaces (thesis section 6.5.4), without the tiles of the textures of lights and with them.
    inject: [(Group, Kernel); 2],
    uses_textures: bool,
    /// Indirect light by ray tracing (thesis section 6.6.1), and ambient occlusion; then sharing between neighbouring
    /// surfaces of one plane.
    gather_group: Group,
    gather: Kernel,
    gather_empty: Kernel,
    share: Kernel,
    /// Propagation from voxel to voxel (thesis section 6.6.2), ping-pong between the two buffers of intensities.
    propagate_groups: [Group; 2],
    seed: Kernel,
    propagate: Kernel,
    deposit: Kernel,
    bound: Bound,
}

/// The bind groups of a frame in which light is computed, as far as it needs them.
#[derive(Default)]
struct Bound {
    compact: Option<BindGroup>,
    inject: Option<BindGroup>,
    gather: Option<BindGroup>,
    propagate: Option<[BindGroup; 2]>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let assets = assets.as_ref();
    let compact_group = Group::new("voxel_gi_compact", &[], &[Work, Irradiance, LightTexture]);
    let compact = load_embedded_asset!(assets, "compact.wesl");
    let compaction =
        |label, entry_point| Kernel::of_light(label, entry_point, &compact, &compact_group);
    let inject = load_embedded_asset!(assets, "inject.wesl");
    let injection = |with_tiles: bool| {
        let reads = [Work, Irradiance, Lights, LightTiles];
        let count = reads.len() - usize::from(!with_tiles);
        // Colours are only read, but in the same buffer as the radiance, which cannot be bound both for reading and for
        // writing.
        let group = Group::new("voxel_gi_inject", &reads[..count], &[Radiance, Colors]);
        let kernel = Kernel::of_light("voxel_gi_inject", "inject", &inject, &group);
        (group, kernel)
    };
    let gather_group = Group::new(
        "voxel_gi_gather",
        &[Work, Radiance, SkyMap, SkySampler],
        &[Irradiance, LightTexture],
    );
    let gather = load_embedded_asset!(assets, "gather.wesl");
    let share = load_embedded_asset!(assets, "share.wesl");
    let gathering = |label, entry_point, shader: &Handle<Shader>| {
        Kernel::of_light(label, entry_point, shader, &gather_group)
    };
    let propagate_groups = [0, 1].map(|from| {
        let reads = [Radiance, Colors, SkyMap, SkySampler, Before(from)];
        let writes = [LightTexture, After(1 - from), Arrived];
        Group::new("voxel_gi_propagate", &reads, &writes)
    });
    let propagate = load_embedded_asset!(assets, "propagate.wesl");
    let propagation =
        |label, entry_point| Kernel::of_light(label, entry_point, &propagate, &propagate_groups[0]);
    commands.insert_resource(SolvePass {
        compact: compaction("voxel_gi_compact", "compact"),
        write_indirect_args: compaction("voxel_gi_write_indirect_args", "write_indirect_args"),
        write_geometry: compaction("voxel_gi_write_geometry", "write_geometry"),
        inject: [false, true].map(injection),
        uses_textures: false,
        gather: gathering("voxel_gi_gather", "gather", &gather),
        gather_empty: gathering("voxel_gi_gather_empty", "gather_empty", &gather),
        share: gathering("voxel_gi_share", "share", &share),
        seed: propagation("voxel_gi_seed", "seed"),
        propagate: propagation("voxel_gi_propagate", "propagate"),
        deposit: propagation("voxel_gi_deposit", "deposit"),
        compact_group,
        gather_group,
        propagate_groups,
        bound: default(),
    });
}

pub(crate) fn queue(
    mut pass: ResMut<SolvePass>,
    volume: Res<ExtractedVolume>,
    (lights, shadow_masks, sky): (Res<ExtractedLights>, ShadowMasks, Res<SkyCube>),
    mut pipelines: Pipelines,
) {
    let Some(volume) = &volume.0 else {
        return;
    };
    let pass = &mut *pass;
    let shape = BufferShape::of(volume);
    let mut defs = light_defs(shape);
    pass.compact.require(&defs, &mut pipelines);
    pass.write_indirect_args.require(&defs, &mut pipelines);
    if volume.patched {
        pass.write_geometry.require(&defs, &mut pipelines);
    }
    if !shape.occlusion_only {
        let mut defs = defs.clone();
        defs.extend(lights.defs());
        defs.extend(shadow_masks.defs(shape));
        pass.uses_textures = lights.has_textures();
        let (_, inject) = &mut pass.inject[usize::from(pass.uses_textures)];
        inject.require(&defs, &mut pipelines);
    }
    defs.extend(sky.is_seen().then_some(SKY_MAP_DEF));
    let kernels = if shape.propagates {
        [&mut pass.seed, &mut pass.propagate, &mut pass.deposit]
    } else {
        [&mut pass.gather, &mut pass.gather_empty, &mut pass.share]
    };
    let count = 2 + usize::from(shape.propagates || shape.shares_light());
    for kernel in kernels.into_iter().take(count) {
        kernel.require(&defs, &mut pipelines);
    }
}

pub(crate) fn prepare(mut pass: ResMut<SolvePass>, plan: Res<FramePlan>, groups: BindGroups) {
    pass.bound = default();
    let (Some(_), Some(buffers)) = (plan.work, &groups.buffers) else {
        return;
    };
    let shape = buffers.shape;
    let (inject, _) = &pass.inject[usize::from(pass.uses_textures)];
    let mut bound = Bound {
        compact: groups.bind(&pass.compact_group),
        ..default()
    };
    if !shape.occlusion_only {
        bound.inject = groups.bind(inject);
    }
    if shape.propagates {
        bound.propagate = groups.bind_both(&pass.propagate_groups);
    } else {
        bound.gather = groups.bind(&pass.gather_group);
    }
    pass.bound = bound;
}

pub(crate) fn solve(
    mut context: RenderContext,
    pass: Res<SolvePass>,
    plan: Res<FramePlan>,
    voxels: Option<Res<VoxelBindGroups>>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some(work), Some(voxels), Some(buffers)) = (plan.work, voxels, buffers) else {
        return;
    };
    // Records kernels over the compacted work, each with its indirect arguments.
    let record = |context: &mut RenderContext,
                  label: &'static str,
                  bounce: usize,
                  group: Option<&BindGroup>,
                  kernels: &[(&Kernel, u64)]| {
        record_pass(context, label, |pass| {
            let Some(group) = group else {
                return;
            };
            pass.set_bind_group(0, &voxels.bounces[bounce], &[]);
            pass.set_bind_group(1, group, &[]);
            for (kernel, args) in kernels {
                if let Some(pipeline) = kernel.pipeline(&cache) {
                    pass.set_pipeline(pipeline);
                    pass.dispatch_workgroups_indirect(&buffers.indirect_args, *args);
                }
            }
        });
    };
    let inject = |context: &mut RenderContext, bounce: usize| {
        if !buffers.shape.occlusion_only {
            let (_, inject) = &pass.inject[usize::from(pass.uses_textures)];
            let kernels = [(inject, VolumeBuffers::SURFACE_ARGS)];
            let group = pass.bound.inject.as_ref();
            record(context, "voxel_gi_inject", bounce, group, &kernels);
        }
    };
    pass.compact(&mut context, work, &voxels, &buffers, &cache);
    if buffers.shape.propagates {
        inject(&mut context, 0);
        record_pass(&mut context, "voxel_gi_propagate", |compute| {
            compute.set_bind_group(0, &voxels.bounces[0], &[]);
            pass.record_propagation(compute, work.iterations, &buffers, &cache);
        });
        return;
    }
    let gathered = pass.bound.gather.as_ref();
    let kernels = [
        (&pass.gather, VolumeBuffers::SURFACE_ARGS),
        (&pass.gather_empty, VolumeBuffers::EMPTY_VOXEL_ARGS),
    ];
    for bounce in 0..work.bounces {
        let group = uniform_of(bounce, work.bounces);
        inject(&mut context, group);
        let is_last = bounce + 1 == work.bounces;
        let kernels = &kernels[..1 + usize::from(is_last)];
        record(&mut context, "voxel_gi_gather", group, gathered, kernels);
    }
    if buffers.shape.shares_light() && !work.is_held {
        let kernels = [(&pass.share, VolumeBuffers::SURFACE_THREAD_ARGS)];
        record(&mut context, "voxel_gi_share", 0, gathered, &kernels);
    }
}

impl SolvePass {
    fn compact(
        &self,
        context: &mut RenderContext,
        work: FrameWork,
        voxels: &VoxelBindGroups,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let (Some(group), Some(compact), Some(write_indirect_args)) = (
            &self.bound.compact,
            self.compact.pipeline(cache),
            self.write_indirect_args.pipeline(cache),
        ) else {
            return;
        };
        let write_geometry = self.write_geometry.pipeline(cache);
        let write_geometry = write_geometry.filter(|_| work.voxelizes.is_some());
        let counters = Some(VolumeBuffers::COUNTERS_SIZE);
        let encoder = context.command_encoder();
        encoder.clear_buffer(&buffers.work, 0, counters);
        record_pass(context, "voxel_gi_compact", |pass| {
            pass.set_bind_group(0, &voxels.bounces[0], &[]);
            pass.set_bind_group(1, group, &[]);
            dispatch_voxels(pass, compact, buffers);
            if let Some(write_geometry) = write_geometry {
                dispatch_voxels(pass, write_geometry, buffers);
            }
            pass.set_pipeline(write_indirect_args);
            pass.dispatch_workgroups(1, 1, 1);
        });
        // A buffer cannot be both writable storage and indirect arguments in one pass.
        context.command_encoder().copy_buffer_to_buffer(
            &buffers.work,
            VolumeBuffers::ARGS_OFFSET,
            &buffers.indirect_args,
            0,
            VolumeBuffers::ARGS_SIZE,
        );
    }

    /// Records all steps, where group 0 is set already.
    fn record_propagation(
        &self,
        pass: &mut ComputePass<'_>,
        iterations: u32,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let (Some(groups), Some(seed), Some(propagate), Some(deposit)) = (
            &self.bound.propagate,
            self.seed.pipeline(cache),
            self.propagate.pipeline(cache),
            self.deposit.pipeline(cache),
        ) else {
            return;
        };
        // `seed` writes the first buffer, which the first step reads.
        pass.set_bind_group(1, &groups[1], &[]);
        dispatch_voxels(pass, seed, buffers);
        for step in 0..iterations {
            pass.set_bind_group(1, &groups[step as usize % 2], &[]);
            dispatch_voxels(pass, propagate, buffers);
        }
        dispatch_voxels(pass, deposit, buffers);
    }
}

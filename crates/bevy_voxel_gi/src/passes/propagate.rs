//! Propagates light from voxel to voxel (thesis section 6.6.2).

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{BindGroup, BindGroupLayoutDescriptor, ComputePass, PipelineCache},
        texture::GpuImage,
    },
};

use super::{
    bindings::{
        BindGroups, COLORS, LIGHT_TEXTURE, RADIANCE, SKY_MAP, SKY_SAMPLER, group_layout,
        light_texture, read_only, read_write, sky_map, sky_sampler,
    },
    draw_sky::{SKY_MAP_DEF, SkyCube},
    kernel::{Kernel, dispatch_voxels, light_defs},
};
use crate::{
    extract::volume::ExtractedVolume,
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        pipelines::RequiredPipelines,
        plan::FramePlan,
    },
};

/// Propagated light before and after a step, and the light that has arrived.
const BEFORE: u32 = 7;
const AFTER: u32 = 8;
const ARRIVED: u32 = 9;

#[derive(Resource)]
pub(crate) struct PropagatePass {
    layout: BindGroupLayoutDescriptor,
    seed: Kernel,
    propagate: Kernel,
    deposit: Kernel,
    /// Ping-pong between the two buffers of intensities; `None` if rays are traced.
    bind_groups: Option<[BindGroup; 2]>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = group_layout(
        "voxel_gi_propagate",
        (
            (RADIANCE, read_only()),
            (COLORS, read_only()),
            (LIGHT_TEXTURE, light_texture()),
            (SKY_MAP, sky_map()),
            (SKY_SAMPLER, sky_sampler()),
            (BEFORE, read_only()),
            (AFTER, read_write()),
            (ARRIVED, read_write()),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "propagate.wesl");
    let kernel = |label, entry_point| Kernel::of_light(label, entry_point, &shader, &layout);
    commands.insert_resource(PropagatePass {
        seed: kernel("voxel_gi_seed", "seed"),
        propagate: kernel("voxel_gi_propagate", "propagate"),
        deposit: kernel("voxel_gi_deposit", "deposit"),
        layout,
        bind_groups: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<PropagatePass>,
    volume: Res<ExtractedVolume>,
    sky: Res<SkyCube>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let shape = volume.0.as_ref().map(BufferShape::of);
    if let Some(shape) = shape.filter(|shape| shape.propagates) {
        let mut defs = light_defs(shape);
        defs.extend(sky.is_seen().then_some(SKY_MAP_DEF));
        pass.seed.require(&defs, &cache, &mut required);
        pass.propagate.require(&defs, &cache, &mut required);
        pass.deposit.require(&defs, &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<PropagatePass>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    images: Res<RenderAssets<GpuImage>>,
    (sky, groups): (Res<SkyCube>, BindGroups),
) {
    pass.bind_groups = None;
    let (Some(_), Some(volume), Some(buffers)) = (plan.work, &volume.0, buffers) else {
        return;
    };
    let Some(sky) = &sky.cube else {
        return;
    };
    let (Some(texture), true) = (images.get(&volume.texture), buffers.shape.propagates) else {
        return;
    };
    let bind_groups = [0, 1].map(|from| {
        groups.create(
            &pass.layout,
            (
                (RADIANCE, buffers.radiance()),
                (COLORS, buffers.colors()),
                (LIGHT_TEXTURE, &texture.texture_view),
                (SKY_MAP, &sky.view),
                (SKY_SAMPLER, &sky.sampler),
                (BEFORE, buffers.intensity[from].as_entire_binding()),
                (AFTER, buffers.intensity[1 - from].as_entire_binding()),
                (ARRIVED, buffers.arrived.as_entire_binding()),
            ),
        )
    });
    pass.bind_groups = Some(bind_groups);
}

impl PropagatePass {
    /// Records all steps, where group 0 is set already.
    pub(super) fn record(
        &self,
        pass: &mut ComputePass<'_>,
        iterations: u32,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let (Some(groups), Some(seed), Some(propagate), Some(deposit)) = (
            &self.bind_groups,
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

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "propagate.wesl");
}

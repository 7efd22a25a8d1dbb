//! Gathers indirect light by ray tracing (thesis section 6.6.1), and ambient occlusion; then shares the light of
//! neighbouring surfaces of one plane.

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
        BindGroups, IRRADIANCE, LIGHT_TEXTURE, RADIANCE, SKY_MAP, SKY_SAMPLER, WORK, group_layout,
        light_texture, read_only, read_write, sky_map, sky_sampler,
    },
    draw_sky::{SKY_MAP_DEF, SkyCube},
    kernel::{Kernel, light_defs},
};
use crate::{
    extract::volume::ExtractedVolume,
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        pipelines::RequiredPipelines,
        plan::FramePlan,
    },
};

#[derive(Resource)]
pub(crate) struct GatherPass {
    layout: BindGroupLayoutDescriptor,
    gather: Kernel,
    gather_empty: Kernel,
    share: Kernel,
    /// `None` if light is propagated.
    bind_group: Option<BindGroup>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = group_layout(
        "voxel_gi_gather",
        (
            (WORK, read_only()),
            (RADIANCE, read_only()),
            (IRRADIANCE, read_write()),
            (LIGHT_TEXTURE, light_texture()),
            (SKY_MAP, sky_map()),
            (SKY_SAMPLER, sky_sampler()),
        ),
    );
    let kernel = |label, entry_point, shader: &Handle<Shader>| {
        Kernel::of_light(label, entry_point, shader, &layout)
    };
    let gather = load_embedded_asset!(assets.as_ref(), "gather.wesl");
    let share = load_embedded_asset!(assets.as_ref(), "share.wesl");
    commands.insert_resource(GatherPass {
        gather: kernel("voxel_gi_gather", "gather", &gather),
        gather_empty: kernel("voxel_gi_gather_empty", "gather_empty", &gather),
        share: kernel("voxel_gi_share", "share", &share),
        layout,
        bind_group: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<GatherPass>,
    volume: Res<ExtractedVolume>,
    sky: Res<SkyCube>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let shape = volume.0.as_ref().map(BufferShape::of);
    if let Some(shape) = shape.filter(|shape| !shape.propagates) {
        let mut defs = light_defs(shape);
        defs.extend(sky.is_seen().then_some(SKY_MAP_DEF));
        pass.gather.require(&defs, &cache, &mut required);
        pass.gather_empty.require(&defs, &cache, &mut required);
        if shape.shares_light() {
            pass.share.require(&defs, &cache, &mut required);
        }
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<GatherPass>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    images: Res<RenderAssets<GpuImage>>,
    (sky, groups): (Res<SkyCube>, BindGroups),
) {
    pass.bind_group = None;
    let (Some(_), Some(volume), Some(buffers)) = (plan.work, &volume.0, buffers) else {
        return;
    };
    let Some(sky) = &sky.cube else {
        return;
    };
    let (Some(texture), false) = (images.get(&volume.texture), buffers.shape.propagates) else {
        return;
    };
    pass.bind_group = Some(groups.create(
        &pass.layout,
        (
            (WORK, buffers.work.as_entire_binding()),
            (RADIANCE, buffers.radiance()),
            (IRRADIANCE, buffers.irradiance.as_entire_binding()),
            (LIGHT_TEXTURE, &texture.texture_view),
            (SKY_MAP, &sky.view),
            (SKY_SAMPLER, &sky.sampler),
        ),
    ));
}

impl GatherPass {
    /// Records gathering over surfaces, and over empty voxels too if asked for; group 0 is set already.
    pub(super) fn record_gather(
        &self,
        pass: &mut ComputePass<'_>,
        with_empty_voxels: bool,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let (Some(group), Some(gather), Some(gather_empty)) = (
            &self.bind_group,
            self.gather.pipeline(cache),
            self.gather_empty.pipeline(cache),
        ) else {
            return;
        };
        pass.set_bind_group(1, group, &[]);
        pass.set_pipeline(gather);
        pass.dispatch_workgroups_indirect(&buffers.indirect_args, VolumeBuffers::SURFACE_ARGS);
        if with_empty_voxels {
            pass.set_pipeline(gather_empty);
            pass.dispatch_workgroups_indirect(
                &buffers.indirect_args,
                VolumeBuffers::EMPTY_VOXEL_ARGS,
            );
        }
    }

    /// Records sharing; group 0 is set already.
    pub(super) fn record_share(
        &self,
        pass: &mut ComputePass<'_>,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let (Some(group), Some(share)) = (&self.bind_group, self.share.pipeline(cache)) else {
            return;
        };
        pass.set_bind_group(1, group, &[]);
        pass.set_pipeline(share);
        pass.dispatch_workgroups_indirect(
            &buffers.indirect_args,
            VolumeBuffers::SURFACE_THREAD_ARGS,
        );
    }
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "gather.wesl");
    embedded_asset!(app, "share.wesl");
}

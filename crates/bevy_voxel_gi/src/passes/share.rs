//! Shares gathered light between neighbouring surfaces of one plane.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            ComputePass, PipelineCache, ShaderStages,
        },
        renderer::RenderDevice,
        texture::GpuImage,
    },
};

use super::{
    bindings::{COUNTERS, IRRADIANCE, LIGHT_TEXTURE, WORK_ITEMS, light_texture, read_only},
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
pub(crate) struct SharePass {
    layout: BindGroupLayoutDescriptor,
    share: Kernel,
    /// `None` if light is not traced from surface to surface.
    bind_group: Option<BindGroup>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_share",
        &BindGroupLayoutEntries::with_indices(
            ShaderStages::COMPUTE,
            (
                (WORK_ITEMS, read_only()),
                (COUNTERS, read_only()),
                (IRRADIANCE, read_only()),
                (LIGHT_TEXTURE, light_texture()),
            ),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "share.wesl");
    commands.insert_resource(SharePass {
        share: Kernel::of_light("voxel_gi_share", "share", &shader, &layout),
        layout,
        bind_group: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<SharePass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let shape = volume.0.as_ref().map(BufferShape::of);
    if let Some(shape) = shape.filter(|shape| shape.keeps_light()) {
        pass.share
            .require(&light_defs(shape), &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<SharePass>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    images: Res<RenderAssets<GpuImage>>,
    (cache, device): (Res<PipelineCache>, Res<RenderDevice>),
) {
    pass.bind_group = None;
    let (Some(_), Some(volume), Some(buffers)) = (plan.work, &volume.0, buffers) else {
        return;
    };
    if !buffers.shape.keeps_light() {
        return;
    }
    let Some(texture) = images.get(&volume.texture) else {
        return;
    };
    pass.bind_group = Some(device.create_bind_group(
        "voxel_gi_share",
        &cache.get_bind_group_layout(&pass.layout),
        &BindGroupEntries::with_indices((
            (WORK_ITEMS, buffers.work_items.as_entire_binding()),
            (COUNTERS, buffers.counters.as_entire_binding()),
            (IRRADIANCE, buffers.irradiance.as_entire_binding()),
            (LIGHT_TEXTURE, &texture.texture_view),
        )),
    ));
}

impl SharePass {
    /// Records the pass; group 0 is set already.
    pub(super) fn record(
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
    embedded_asset!(app, "share.wesl");
}

//! Compacts the surfaces and the empty voxels, so that later passes have one workgroup for each; and writes what pixels read
//! of new voxels beside their light.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{BindGroup, BindGroupLayoutDescriptor, PipelineCache},
        renderer::RenderContext,
        texture::GpuImage,
    },
};

use super::{
    bindings::{
        BindGroups, IRRADIANCE, LIGHT_TEXTURE, VoxelBindGroups, WORK, group_layout, light_texture,
        read_write,
    },
    kernel::{Kernel, dispatch_voxels, light_defs, record_pass},
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
pub(crate) struct CompactPass {
    layout: BindGroupLayoutDescriptor,
    compact: Kernel,
    write_indirect_args: Kernel,
    write_geometry: Kernel,
    bind_group: Option<BindGroup>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = group_layout(
        "voxel_gi_compact",
        (
            (WORK, read_write()),
            (IRRADIANCE, read_write()),
            (LIGHT_TEXTURE, light_texture()),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "compact.wesl");
    let kernel = |label, entry_point| Kernel::of_light(label, entry_point, &shader, &layout);
    commands.insert_resource(CompactPass {
        compact: kernel("voxel_gi_compact", "compact"),
        write_indirect_args: kernel("voxel_gi_write_indirect_args", "write_indirect_args"),
        write_geometry: kernel("voxel_gi_write_geometry", "write_geometry"),
        layout,
        bind_group: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<CompactPass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let Some(volume) = &volume.0 else {
        return;
    };
    let defs = light_defs(BufferShape::of(volume));
    pass.compact.require(&defs, &cache, &mut required);
    pass.write_indirect_args
        .require(&defs, &cache, &mut required);
    if volume.patched {
        pass.write_geometry.require(&defs, &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<CompactPass>,
    plan: Res<FramePlan>,
    volume: Res<ExtractedVolume>,
    buffers: Option<Res<VolumeBuffers>>,
    images: Res<RenderAssets<GpuImage>>,
    groups: BindGroups,
) {
    pass.bind_group = None;
    let (Some(_), Some(volume), Some(buffers)) = (plan.work, &volume.0, buffers) else {
        return;
    };
    pass.bind_group = images.get(&volume.texture).map(|texture| {
        groups.create(
            &pass.layout,
            (
                (WORK, buffers.work.as_entire_binding()),
                (IRRADIANCE, buffers.irradiance.as_entire_binding()),
                (LIGHT_TEXTURE, &texture.texture_view),
            ),
        )
    });
}

pub(crate) fn compact(
    mut context: RenderContext,
    pass: Res<CompactPass>,
    plan: Res<FramePlan>,
    voxels: Option<Res<VoxelBindGroups>>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some(group), Some(voxels), Some(buffers)) = (&pass.bind_group, voxels, buffers) else {
        return;
    };
    let (Some(compact), Some(write_indirect_args)) = (
        pass.compact.pipeline(&cache),
        pass.write_indirect_args.pipeline(&cache),
    ) else {
        return;
    };
    let is_new = plan.work.is_some_and(|work| work.voxelizes.is_some());
    let write_geometry = pass.write_geometry.pipeline(&cache).filter(|_| is_new);
    context
        .command_encoder()
        .clear_buffer(&buffers.work, 0, Some(VolumeBuffers::COUNTERS_SIZE));
    record_pass(&mut context, "voxel_gi_compact", |pass| {
        pass.set_bind_group(0, &voxels.bounces[0], &[]);
        pass.set_bind_group(1, group, &[]);
        dispatch_voxels(pass, compact, &buffers);
        if let Some(write_geometry) = write_geometry {
            dispatch_voxels(pass, write_geometry, &buffers);
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

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "compact.wesl");
}

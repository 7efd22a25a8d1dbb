//! Draws the textures of materials into their tiles, before the scene is voxelised.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BufferDescriptor,
            BufferUsages, PipelineCache, ShaderSize, ShaderStages, StorageTextureAccess,
            TextureFormat, TextureSampleType,
            binding_types::{texture_2d, texture_storage_2d, uniform_buffer},
            encase,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::kernel::{Kernel, record_pass};
use crate::prepare::{
    materials::MaterialRecords,
    pipelines::RequiredPipelines,
    plan::FramePlan,
    tiles::{TileJob, Tiles},
};

#[derive(Resource)]
pub(crate) struct DrawTilesPass {
    layout: BindGroupLayoutDescriptor,
    draw_tile: Kernel,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_draw_tile",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<TileJob>(false),
                texture_2d(TextureSampleType::Float { filterable: false }),
                texture_storage_2d(TextureFormat::R32Uint, StorageTextureAccess::WriteOnly),
            ),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "draw_tiles.wesl");
    commands.insert_resource(DrawTilesPass {
        draw_tile: Kernel::new(
            "voxel_gi_draw_tile",
            "draw_tile",
            &shader,
            vec![layout.clone()],
        ),
        layout,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<DrawTilesPass>,
    materials: Res<MaterialRecords>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    if materials.has_textures {
        pass.draw_tile.require(&[], &cache, &mut required);
    }
}

pub(crate) fn draw_tiles(
    mut context: RenderContext,
    pass: Res<DrawTilesPass>,
    plan: Res<FramePlan>,
    mut tiles: ResMut<Tiles>,
    images: Res<RenderAssets<GpuImage>>,
    (cache, device, queue): (Res<PipelineCache>, Res<RenderDevice>, Res<RenderQueue>),
) {
    let voxelizes = plan.work.is_some_and(|work| work.voxelizes.is_some());
    let (true, Some(pipeline), Some(target)) = (
        voxelizes,
        pass.draw_tile.pipeline(&cache),
        tiles.view().cloned(),
    ) else {
        return;
    };
    let jobs = tiles.bypass_change_detection().take_jobs(&images);
    if jobs.is_empty() {
        return;
    }
    let layout = cache.get_bind_group_layout(&pass.layout);
    let groups: Vec<_> = jobs
        .into_iter()
        .filter_map(|(source, job)| {
            let uniform = device.create_buffer(&BufferDescriptor {
                label: Some("voxel_gi_tile_job"),
                size: TileJob::SHADER_SIZE.get(),
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut bytes = encase::UniformBuffer::new(Vec::new());
            bytes.write(&job).ok()?;
            queue.write_buffer(&uniform, 0, &bytes.into_inner());
            let uniform = uniform.as_entire_binding();
            let entries = BindGroupEntries::sequential((uniform, &source, &target));
            Some(device.create_bind_group("voxel_gi_draw_tile", &layout, &entries))
        })
        .collect();
    record_pass(&mut context, "voxel_gi_draw_tiles", |compute| {
        compute.set_pipeline(pipeline);
        for group in &groups {
            compute.set_bind_group(0, group, &[]);
            compute.dispatch_workgroups(1, 1, 1);
        }
    });
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "draw_tiles.wesl");
}

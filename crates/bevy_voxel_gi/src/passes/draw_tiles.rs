//! Draws textures into their tiles: those of materials before the scene is voxelised, those of lights before direct light.

use bevy::{
    asset::load_embedded_asset,
    ecs::system::SystemParam,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BufferUsages,
            PipelineCache, ShaderSize, ShaderStages, StorageTextureAccess, TextureFormat,
            TextureSampleType, TextureView,
            binding_types::{texture_2d, texture_storage_2d, uniform_buffer},
            encase,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::kernel::{Kernel, Pipelines, record_pass};
use crate::{
    extract::lights::{ExtractedLights, LIGHT_TEXTURES},
    prepare::{
        buffers::buffer,
        materials::MaterialRecords,
        plan::FramePlan,
        tiles::{LightTiles, TileJob, Tiles},
    },
};

#[derive(Resource)]
pub(crate) struct DrawTilesPass {
    layout: BindGroupLayoutDescriptor,
    draw_tile: Kernel,
    draw_light_tile: Kernel,
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
    let kernel = |label| Kernel::new(label, "draw_tile", &shader, &[&layout]);
    commands.insert_resource(DrawTilesPass {
        draw_tile: kernel("voxel_gi_draw_tile"),
        draw_light_tile: kernel("voxel_gi_draw_light_tile"),
        layout,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<DrawTilesPass>,
    (materials, lights): (Res<MaterialRecords>, Res<ExtractedLights>),
    mut pipelines: Pipelines,
) {
    if materials.has_textures {
        pass.draw_tile.require(&[], &mut pipelines);
    }
    if lights.has_textures() {
        let kernel = &mut pass.draw_light_tile;
        kernel.require(&[LIGHT_TEXTURES], &mut pipelines);
    }
}

pub(crate) fn draw_tiles(
    mut context: RenderContext,
    plan: Res<FramePlan>,
    mut tiles: ResMut<Tiles>,
    resources: DrawResources,
) {
    if plan.work.is_some_and(|work| work.voxelizes.is_some()) {
        let (label, kernel) = ("voxel_gi_draw_tiles", &resources.pass.draw_tile);
        let tiles = tiles.bypass_change_detection();
        resources.draw(&mut context, label, kernel, tiles);
    }
}

pub(crate) fn draw_light_tiles(
    mut context: RenderContext,
    plan: Res<FramePlan>,
    mut light_tiles: ResMut<LightTiles>,
    resources: DrawResources,
) {
    if plan.work.is_some() {
        let (label, kernel) = ("voxel_gi_draw_light_tiles", &resources.pass.draw_light_tile);
        resources.draw(&mut context, label, kernel, &mut light_tiles.tiles);
    }
}

#[derive(SystemParam)]
pub(crate) struct DrawResources<'w> {
    pass: Res<'w, DrawTilesPass>,
    images: Res<'w, RenderAssets<GpuImage>>,
    cache: Res<'w, PipelineCache>,
    device: Res<'w, RenderDevice>,
    queue: Res<'w, RenderQueue>,
}

impl DrawResources<'_> {
    /// Records a pass that draws the tiles that have changed.
    fn draw(
        &self,
        context: &mut RenderContext,
        label: &'static str,
        kernel: &Kernel,
        tiles: &mut Tiles,
    ) {
        let Self { device, queue, .. } = self;
        let (Some(pipeline), Some(target)) = (kernel.pipeline(&self.cache), tiles.view().cloned())
        else {
            return;
        };
        let jobs = tiles.take_jobs(&self.images);
        if jobs.is_empty() {
            return;
        }
        let layout = self.cache.get_bind_group_layout(&self.pass.layout);
        let group = |(source, job): (TextureView, TileJob)| {
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            let size = TileJob::SHADER_SIZE.get();
            let uniform = buffer(device, "voxel_gi_tile_job", size, usage);
            let mut bytes = encase::UniformBuffer::new(Vec::new());
            bytes.write(&job).ok()?;
            queue.write_buffer(&uniform, 0, &bytes.into_inner());
            let uniform = uniform.as_entire_binding();
            let entries = BindGroupEntries::sequential((uniform, &source, &target));
            Some(device.create_bind_group("voxel_gi_draw_tile", &layout, &entries))
        };
        let groups: Vec<_> = jobs.into_iter().filter_map(group).collect();
        record_pass(context, label, |compute| {
            compute.set_pipeline(pipeline);
            for group in &groups {
                compute.set_bind_group(0, group, &[]);
                compute.dispatch_workgroups(1, 1, 1);
            }
        });
    }
}

//! Draws the game's sky into a small cube map, which rays sample where they leave all levels: when it changes, and in
//! each frame in which light is computed where the GPU itself draws it.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            AddressMode, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries,
            FilterMode, PipelineCache, Sampler, SamplerBindingType, SamplerDescriptor,
            ShaderStages, ShaderType, StorageTextureAccess, Texture, TextureFormat,
            TextureSampleType, TextureUsages, TextureView, TextureViewDescriptor,
            TextureViewDimension, TextureViewId, UniformBuffer,
            binding_types::{sampler, texture_cube, texture_storage_2d_array, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::kernel::{Kernel, Pipelines, record_pass};
use crate::{
    extract::{game_sky::SkyMap, place_volume::ExtractedVolume, probe::STORAGE_SCALE},
    prepare::{asset_notes::AssetNotes, buffers::texture, plan::FramePlan},
};

/// Texels along an edge of a face: diffuse light has no finer detail.
const SIZE: u32 = 16;
/// Most samples of the source across a texel: all of one of 4,096 texels along an edge are seen.
const MOST_SAMPLES: u32 = 128;

/// The shader def of kernels whose rays see it.
pub(super) const SKY_MAP_DEF: &str = "SKY_MAP";

/// The game's sky.
#[derive(Resource, Default)]
pub(crate) struct SkyCube {
    /// `None` where there is no volume.
    pub cube: Option<Cube>,
    /// The map that the cube has or will have, and its view.
    source: Option<(SkyMap, TextureViewId)>,
    is_drawn: bool,
    /// Increases when there is another sky.
    pub version: u64,
}

/// A cube map, of one texel where rays see none.
pub(crate) struct Cube {
    texture: Texture,
    pub view: TextureView,
    pub sampler: Sampler,
}

impl Cube {
    fn new(device: &RenderDevice, size: u32) -> Self {
        let format = TextureFormat::Rgba16Float;
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING;
        let texture = texture(device, "voxel_gi_sky", [size, size, 6], format, usage);
        Self {
            view: view(&texture, TextureViewDimension::Cube),
            texture,
            sampler: device.create_sampler(&SamplerDescriptor {
                address_mode_u: AddressMode::ClampToEdge,
                address_mode_v: AddressMode::ClampToEdge,
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                ..default()
            }),
        }
    }
}

impl SkyCube {
    /// Whether rays see it.
    pub fn is_seen(&self) -> bool {
        self.source.is_some()
    }

    pub fn bytes(&self) -> u64 {
        let texels = |cube: &Cube| 6 * u64::from(cube.texture.width()).pow(2);
        8 * self.cube.as_ref().map_or(0, texels)
    }
}

fn view(texture: &Texture, dimension: TextureViewDimension) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        dimension: Some(dimension),
        ..default()
    })
}

/// The image of a sky, if it is on the GPU and is a cube map that shaders sample.
fn source_image<'a>(
    map: &SkyMap,
    images: &'a RenderAssets<GpuImage>,
    device: &RenderDevice,
) -> Option<&'a GpuImage> {
    let image = images.get(map.image)?;
    let view = image.texture_view_descriptor.as_ref();
    let is_cube = view.and_then(|view| view.dimension) == Some(TextureViewDimension::Cube);
    let format = image.texture_descriptor.format;
    let sample_type = format.sample_type(None, Some(device.features()));
    if !is_cube || sample_type != Some(TextureSampleType::Float { filterable: true }) {
        warn_once!(
            "voxel GI: the camera's sky is no cube map that shaders can filter (its format is {format:?}), so \
             volumes do not see it. Use a cube map of another format, or set `VoxelGiVolume::sky`"
        );
        return None;
    }
    Some(image)
}

/// Notices that the game has another sky.
pub(crate) fn note_sky(
    mut sky: ResMut<SkyCube>,
    volume: Res<ExtractedVolume>,
    notes: Res<AssetNotes>,
    images: Res<RenderAssets<GpuImage>>,
    device: Res<RenderDevice>,
) {
    let map = volume.0.as_ref().and_then(|volume| volume.sky_map);
    let source = map.and_then(|map| {
        let image = source_image(&map, &images, &device)?;
        Some((map, image.texture_view.id()))
    });
    let is_changed = map.is_some_and(|map| notes.uploaded.contains(&map.image));
    let size = volume.0.as_ref().map_or(0, |_| match source {
        Some(_) => SIZE,
        None => 1,
    });
    let known = sky.cube.as_ref().map_or(0, |cube| cube.texture.width());
    if source == sky.source && !is_changed && size == known {
        return;
    }
    if size != known {
        sky.cube = (size > 0).then(|| Cube::new(&device, size));
    }
    sky.source = source;
    sky.is_drawn = false;
    sky.version += 1;
}

#[derive(ShaderType, Clone, Copy, Debug, Default)]
struct SkyJob {
    sky_from_world: Vec4,
    scale: f32,
    samples: u32,
}

#[derive(Resource)]
pub(crate) struct DrawSkyPass {
    layout: BindGroupLayoutDescriptor,
    draw_sky: Kernel,
    job: UniformBuffer<SkyJob>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_draw_sky",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<SkyJob>(false),
                texture_cube(TextureSampleType::Float { filterable: true }),
                sampler(SamplerBindingType::Filtering),
                texture_storage_2d_array(
                    TextureFormat::Rgba16Float,
                    StorageTextureAccess::WriteOnly,
                ),
            ),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "draw_sky.wesl");
    commands.insert_resource(DrawSkyPass {
        draw_sky: Kernel::new("voxel_gi_draw_sky", "draw_sky", &shader, &[&layout]),
        layout,
        job: UniformBuffer::default(),
    });
}

pub(crate) fn queue(mut pass: ResMut<DrawSkyPass>, sky: Res<SkyCube>, mut pipelines: Pipelines) {
    if sky.is_seen() {
        pass.draw_sky.require(&[], &mut pipelines);
    }
}

pub(crate) fn draw_sky(
    mut context: RenderContext,
    mut pass: ResMut<DrawSkyPass>,
    mut sky: ResMut<SkyCube>,
    plan: Res<FramePlan>,
    images: Res<RenderAssets<GpuImage>>,
    (cache, device, queue): (Res<PipelineCache>, Res<RenderDevice>, Res<RenderQueue>),
) {
    let Some((map, _)) = sky.source.filter(|(map, _)| !sky.is_drawn || map.is_live) else {
        return;
    };
    let pass = &mut *pass;
    let (Some(_), Some(image), Some(pipeline), Some(cube)) = (
        plan.work,
        images.get(map.image),
        pass.draw_sky.pipeline(&cache),
        &sky.cube,
    ) else {
        return;
    };
    // A filtered sample has two texels in each direction.
    let samples = image.texture_descriptor.size.width.div_ceil(2 * SIZE);
    pass.job.set(SkyJob {
        sky_from_world: map.rotation.inverse().into(),
        scale: map.intensity * STORAGE_SCALE,
        samples: samples.clamp(2, MOST_SAMPLES),
    });
    pass.job.write_buffer(&device, &queue);
    let Some(job) = pass.job.binding() else {
        return;
    };
    let target = view(&cube.texture, TextureViewDimension::D2Array);
    let group = device.create_bind_group(
        "voxel_gi_draw_sky",
        &cache.get_bind_group_layout(&pass.layout),
        &BindGroupEntries::sequential((job, &image.texture_view, &cube.sampler, &target)),
    );
    record_pass(&mut context, "voxel_gi_draw_sky", |compute| {
        compute.set_pipeline(pipeline);
        compute.set_bind_group(0, &group, &[]);
        compute.dispatch_workgroups(SIZE, SIZE, 6);
    });
    sky.is_drawn = true;
}

//! The textures of filtered materials in the renderer: their mip levels and samplers. The images of the app stay as they
//! are.
//!
//! Bevy creates the texture of an image with room for its levels, where materials show it by then, and later edits of the
//! image write the finest level. A texture that was there before stays, since others may hold it: materials show a copy
//! with levels, which follows its edits. So do they with a texture that cameras draw to.

use std::collections::{HashMap, HashSet};

use bevy::{
    camera::NormalizedRenderTarget,
    core_pipeline::{Core2d, Core3d, schedule::camera_driver, upscaling::upscaling},
    ecs::{schedule::Schedules, system::SystemParam},
    image::ImageSamplerDescriptor,
    prelude::*,
    render::{
        Extract, ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderSystems,
        camera::ExtractedCamera,
        render_asset::{AssetExtractionSystems, ExtractedAssets, RenderAssets, prepare_assets},
        render_resource::{
            CommandEncoder, CommandEncoderDescriptor, Sampler, SamplerId, Texture,
            TextureDataOrder, TextureDescriptor, TextureUsages, TextureView, TextureViewDescriptor,
        },
        renderer::{
            RenderContext, RenderDevice, RenderGraph, RenderGraphSystems, RenderQueue, ViewQuery,
        },
        texture::GpuImage,
    },
};

use super::filtered::{FilteredMaterials, PrepareSystems, TextureRequest};
use crate::mips::generator::{Levels, MipGenerator};

/// Prepares textures before the materials that show them.
pub(super) struct PreparedTexturesPlugin;

/// Generates the mip levels of images that shaders write, for which the app has set
/// [`EwaImage::after_draws`](crate::EwaImage::after_draws). It is in Bevy's schedule `RenderGraph`, before all cameras:
/// systems that write such images run before it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct EwaMipSystems;

impl Plugin for PreparedTexturesPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<PreparedTextures>()
            .init_resource::<OriginalViews>()
            .init_gpu_resource::<MipGenerator>()
            .add_systems(
                ExtractSchedule,
                extract_textures.after(AssetExtractionSystems),
            )
            .configure_sets(
                Render,
                (
                    PrepareSystems::BeforeMaterials
                        .after(prepare_assets::<GpuImage>)
                        .in_set(RenderSystems::PrepareAssets),
                    PrepareSystems::AfterMaterials
                        .after(PrepareSystems::BeforeMaterials)
                        .in_set(RenderSystems::PrepareAssets),
                ),
            )
            .add_systems(
                Render,
                (
                    (prepare_textures, show_levels)
                        .chain()
                        .in_set(PrepareSystems::BeforeMaterials),
                    hide_levels.in_set(PrepareSystems::AfterMaterials),
                ),
            )
            .add_systems(
                RenderGraph,
                follow_shaders
                    .in_set(EwaMipSystems)
                    .in_set(RenderGraphSystems::Render)
                    .before(camera_driver),
            );
    }
}

#[derive(Resource, Default)]
struct PreparedTextures {
    requests: HashMap<AssetId<Image>, TextureRequest>,
    /// Textures to look at in this frame, or once they are on the GPU.
    changed: HashSet<AssetId<Image>>,
    /// The levels of textures that Bevy created with room for them.
    allocated_levels: HashMap<AssetId<Image>, u32>,
    copies: HashMap<AssetId<Image>, MippedCopy>,
    samplers: HashMap<AssetId<Image>, ReplacedSampler>,
    /// Whether levels follow the draws of cameras.
    follows_cameras: bool,
}

fn extract_textures(
    mut commands: Commands,
    filtered: Extract<Res<FilteredMaterials>>,
    mut prepared: ResMut<PreparedTextures>,
    mut extracted: ResMut<ExtractedAssets<GpuImage>>,
    images: Res<RenderAssets<GpuImage>>,
) {
    let prepared = &mut *prepared;
    for (id, texture) in &filtered.changes.textures {
        prepared.changed.insert(*id);
        let follows = texture.as_ref().is_some_and(|texture| texture.after_draws);
        if follows && !prepared.follows_cameras {
            prepared.follows_cameras = true;
            commands.queue(follow_cameras);
        }
        match texture {
            Some(texture) => prepared.requests.insert(*id, texture.clone()),
            None => prepared.requests.remove(id),
        };
    }
    for (id, image) in &mut extracted.extracted {
        let request = prepared.requests.get(id);
        if request.is_some() {
            prepared.changed.insert(*id);
        }
        let request = request.filter(|request| !request.after_draws);
        let requested = request.map(|request| request.levels);
        let allocated = prepared.allocated_levels.remove(id);
        if let Some(levels) = allocate_levels(image, images.get(*id), allocated, requested) {
            prepared.allocated_levels.insert(*id, levels);
        }
    }
}

/// Has Bevy create the texture of an image with room for levels, unless there is a texture that Bevy is about to edit.
/// Returns the number of levels of a texture with room for them.
fn allocate_levels(
    image: &mut Image,
    previous: Option<&GpuImage>,
    allocated: Option<u32>,
    requested: Option<u32>,
) -> Option<u32> {
    let own = &image.texture_descriptor;
    let with_levels = |levels| TextureDescriptor {
        mip_level_count: levels,
        usage: own.usage | TextureUsages::RENDER_ATTACHMENT,
        ..own.clone()
    };
    let is_writable = image.data.is_none() || own.usage.contains(TextureUsages::COPY_DST);
    let is_edit = |descriptor: &TextureDescriptor<'static>| {
        is_writable && previous.is_some_and(|previous| previous.texture_descriptor == *descriptor)
    };
    let levels = match allocated.filter(|allocated| is_edit(&with_levels(*allocated))) {
        Some(allocated) => allocated,
        None if is_edit(own) => return None,
        None => requested.filter(|levels| *levels > 1)?,
    };
    let size = own.size;
    let texel = own.format.block_copy_size(None)? as usize;
    let level_bytes = |level: u32| {
        let [width, height] = [size.width, size.height].map(|side| (side >> level).max(1) as usize);
        width * height * size.depth_or_array_layers as usize * texel
    };
    let descriptor = with_levels(levels);
    if let Some(data) = &mut image.data {
        if data.len() != level_bytes(0) {
            return None;
        }
        // What is uploaded to these levels is drawn over.
        data.resize((0..levels).map(level_bytes).sum(), 0);
        image.data_order = TextureDataOrder::MipMajor;
    }
    image.texture_descriptor = descriptor;
    if let Some(view) = &mut image.texture_view_descriptor {
        view.mip_level_count = None;
    }
    Some(levels)
}

fn prepare_textures(
    mut prepared: ResMut<PreparedTextures>,
    mut images: ResMut<RenderAssets<GpuImage>>,
    mut generator: ResMut<MipGenerator>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    if prepared.changed.is_empty() {
        return;
    }
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
        label: Some("bevy_ewa_mips"),
    });
    let prepared = &mut *prepared;
    for id in std::mem::take(&mut prepared.changed) {
        let request = prepared.requests.get(&id);
        let Some(image) = images.get_mut(id) else {
            prepared.copies.remove(&id);
            prepared.samplers.remove(&id);
            if request.is_some() {
                // Bevy prepares it in a later frame.
                prepared.changed.insert(id);
            }
            continue;
        };
        let sampler = request.and_then(|request| request.sampler.as_ref());
        replace_sampler(&mut prepared.samplers, id, image, sampler, &device);
        let copy = prepared.copies.remove(&id);
        let allocated = prepared.allocated_levels.get(&id).copied();
        let Some(request) = request.filter(|request| request.levels > 1) else {
            if copy.is_some() || allocated.is_some() {
                image.texture_view = view(image, &image.texture, 1);
            }
            continue;
        };
        if allocated.is_some_and(|allocated| allocated >= request.levels) {
            let levels = request.levels_of(&image.texture);
            generator.generate(&device, &mut encoder, &levels, request.content);
            image.texture_view = view(image, &image.texture, request.levels);
            continue;
        }
        let copy = copy.filter(|copy| copy.fits(image, request));
        let copy = copy.unwrap_or_else(|| MippedCopy::new(image, request, &device));
        copy.update(
            &image.texture,
            request,
            &mut generator,
            &device,
            &mut encoder,
        );
        if !request.after_draws {
            image.texture_view = copy.view.clone();
        }
        prepared.copies.insert(id, copy);
    }
    queue.submit([encoder.finish()]);
}

impl TextureRequest {
    fn levels_of<'a>(&self, texture: &'a Texture) -> Levels<'a> {
        Levels {
            texture,
            format: self.format,
            count: self.levels,
        }
    }
}

/// The view of a texture with these levels that the image asks for.
fn view(image: &GpuImage, texture: &Texture, levels: u32) -> TextureView {
    let descriptor = image.texture_view_descriptor.clone().unwrap_or_default();
    texture.create_view(&TextureViewDescriptor {
        mip_level_count: Some(levels),
        ..descriptor
    })
}

/// A texture with levels that materials show instead of the original, which has none.
struct MippedCopy {
    texture: Texture,
    view: TextureView,
}

impl MippedCopy {
    fn new(image: &GpuImage, request: &TextureRequest, device: &RenderDevice) -> Self {
        let descriptor = &image.texture_descriptor;
        let texture = device.create_texture(&TextureDescriptor {
            label: Some("bevy_ewa_mips_copy"),
            mip_level_count: request.levels,
            usage: TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_DST
                | TextureUsages::RENDER_ATTACHMENT,
            ..descriptor.clone()
        });
        Self {
            view: view(image, &texture, request.levels),
            texture,
        }
    }

    fn fits(&self, image: &GpuImage, request: &TextureRequest) -> bool {
        self.texture.mip_level_count() == request.levels
            && self.texture.size() == image.texture.size()
            && self.texture.format() == image.texture.format()
    }

    /// Follows the texture without levels.
    fn update(
        &self,
        original: &Texture,
        request: &TextureRequest,
        generator: &mut MipGenerator,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
    ) {
        let levels = request.levels_of(&self.texture);
        generator.copy(device, encoder, &request.levels_of(original), &levels);
        generator.generate(device, encoder, &levels, request.content);
    }
}

/// A sampler that replaces the image's.
struct ReplacedSampler {
    original: Sampler,
    id: SamplerId,
    descriptor: ImageSamplerDescriptor,
}

fn replace_sampler(
    samplers: &mut HashMap<AssetId<Image>, ReplacedSampler>,
    id: AssetId<Image>,
    image: &mut GpuImage,
    requested: Option<&ImageSamplerDescriptor>,
    device: &RenderDevice,
) {
    if let Some(replaced) = samplers.remove(&id)
        // An image that was prepared again has its own sampler again.
        && image.sampler.id() == replaced.id
    {
        if requested == Some(&replaced.descriptor) {
            samplers.insert(id, replaced);
            return;
        }
        image.sampler = replaced.original;
    }
    if let Some(descriptor) = requested {
        let sampler = device.create_sampler(&descriptor.as_wgpu());
        let replaced = ReplacedSampler {
            id: sampler.id(),
            original: std::mem::replace(&mut image.sampler, sampler),
            descriptor: descriptor.clone(),
        };
        samplers.insert(id, replaced);
    }
}

/// Materials that are prepared now show the levels of textures that cameras draw to...
fn show_levels(
    prepared: Res<PreparedTextures>,
    mut images: ResMut<RenderAssets<GpuImage>>,
    mut originals: ResMut<OriginalViews>,
) {
    for (id, copy) in &prepared.copies {
        let request = prepared.requests.get(id);
        if request.is_some_and(|request| request.after_draws)
            && let Some(image) = images.get_mut(*id)
        {
            let original = std::mem::replace(&mut image.texture_view, copy.view.clone());
            originals.0.push((*id, original));
        }
    }
}

/// ... and cameras draw to a view without levels.
fn hide_levels(mut images: ResMut<RenderAssets<GpuImage>>, mut originals: ResMut<OriginalViews>) {
    for (id, original) in originals.0.drain(..) {
        if let Some(image) = images.get_mut(id) {
            image.texture_view = original;
        }
    }
}

/// The views that [`show_levels`] replaced.
#[derive(Resource, Default)]
struct OriginalViews(Vec<(AssetId<Image>, TextureView)>);

/// The schedules of cameras stay Bevy's in apps that do not need it.
fn follow_cameras(world: &mut World) {
    let mut schedules = world.resource_mut::<Schedules>();
    schedules.add_systems(Core3d, follow_camera.after(upscaling));
    schedules.add_systems(Core2d, follow_camera.after(upscaling));
}

/// Generates the levels of the image to which a camera has drawn.
fn follow_camera(camera: ViewQuery<&ExtractedCamera>, mut follower: Follower) {
    if let Some(NormalizedRenderTarget::Image(target)) = &camera.into_inner().target {
        follower.follow(target.handle.id());
    }
}

/// Generates the levels of the images that shaders write.
fn follow_shaders(mut follower: Follower) {
    let ids: Vec<_> = follower.prepared.copies.keys().copied().collect();
    for id in ids {
        let image = follower.images.get(id);
        if image.is_some_and(|i| i.texture.usage().contains(TextureUsages::STORAGE_BINDING)) {
            follower.follow(id);
        }
    }
}

/// Generates levels after draws.
#[derive(SystemParam)]
struct Follower<'w, 's> {
    prepared: Res<'w, PreparedTextures>,
    images: Res<'w, RenderAssets<GpuImage>>,
    generator: ResMut<'w, MipGenerator>,
    device: Res<'w, RenderDevice>,
    context: RenderContext<'w, 's>,
}

impl Follower<'_, '_> {
    fn follow(&mut self, id: AssetId<Image>) {
        if let Some(copy) = self.prepared.copies.get(&id)
            && let Some(request) = self.prepared.requests.get(&id)
            && request.after_draws
            && let Some(image) = self.images.get(id)
        {
            let encoder = self.context.command_encoder();
            copy.update(
                &image.texture,
                request,
                &mut self.generator,
                &self.device,
                encoder,
            );
        }
    }
}

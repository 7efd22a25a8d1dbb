//! Allocation of the packed textures.

use bevy::{
    ecs::entity::EntityHashMap,
    image::ToExtents,
    pbr::{Transmissive3d, ViewTransmissionTexture},
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
        },
        renderer::{RenderAdapterInfo, RenderDevice},
        sync_world::MainEntity,
        texture::{CachedTexture, TextureCache},
        view::{ExtractedView, ViewTarget},
    },
};

use super::{conditions::draws_colors, eligibility::Decisions, formatted::PackedView};
use crate::report::{ColorMemory, FrameBufferReport, RenderedReports};

/// Format of the HDR background of transmissive objects.
pub(crate) const TRANSMISSION_FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// The textures into which a packed view draws.
#[derive(Component, Clone)]
pub(crate) struct PackedTextures {
    /// Texture with one sample per pixel, as the render target or the target of the hardware resolve.
    /// `None` if the resolve shader reads the samples.
    pub single_sampled: Option<CachedTexture>,
    /// Multisampled texture; `None` if the view has one sample per pixel.
    pub multisampled: Option<CachedTexture>,
    /// Whether the resolve shader reads the samples.
    pub samples_are_read: bool,
}

impl PackedTextures {
    /// Returns the texture that the resolve shader reads.
    pub(crate) fn resolve_source(&self) -> Option<&CachedTexture> {
        self.single_sampled.as_ref().or(self.multisampled.as_ref())
    }
}

/// Allocates the textures of packed views. Cameras with the same target draw one after the other and
/// share them, as they share Bevy's depth texture.
pub(super) fn prepare_textures(
    mut commands: Commands,
    mut cache: ResMut<TextureCache>,
    device: Res<RenderDevice>,
    views: Query<(Entity, &PackedView, &ExtractedCamera, &ExtractedView)>,
    stale: Query<Entity, (With<PackedTextures>, Without<PackedView>)>,
    transmissive_phases: Res<ViewSortedRenderPhases<Transmissive3d>>,
) {
    for entity in &stale {
        commands.entity(entity).remove::<PackedTextures>();
    }
    let mut shared: HashMap<_, PackedTextures> = HashMap::default();
    for (entity, packed, camera, view) in &views {
        let Some(size) = camera.physical_target_size else {
            commands.entity(entity).remove::<PackedTextures>();
            continue;
        };
        let is_one_pass = transmissive_phases
            .get(&view.retained_view_entity)
            .is_none_or(|phase| phase.items.is_empty());
        let key = (
            camera.target.clone(),
            packed.format,
            packed.samples,
            packed.hardware_resolve,
            is_one_pass,
        );
        let textures = shared
            .entry(key)
            .or_insert_with(|| create(&mut cache, &device, packed, size, is_one_pass));
        commands.entity(entity).insert(textures.clone());
    }
}

fn create(
    cache: &mut TextureCache,
    device: &RenderDevice,
    packed: &PackedView,
    size: UVec2,
    is_one_pass: bool,
) -> PackedTextures {
    let mut texture = |label, sample_count, usage| {
        let descriptor = TextureDescriptor {
            label: Some(label),
            size: size.to_extents(),
            mip_level_count: 1,
            sample_count,
            dimension: TextureDimension::D2,
            format: packed.format.texture_format(),
            usage,
            view_formats: &[],
        };
        cache.get(device, descriptor)
    };
    let attachment = TextureUsages::RENDER_ATTACHMENT;
    let read = attachment | TextureUsages::TEXTURE_BINDING;
    let multisampled = packed.samples > 1;
    let samples_are_read = !packed.hardware_resolve || packed.has_linear_light();
    PackedTextures {
        single_sampled: (!multisampled || packed.hardware_resolve)
            .then(|| texture("packed_ycocg", 1, read)),
        multisampled: multisampled.then(|| {
            let usage = if samples_are_read {
                read
            } else if is_one_pass {
                // Samples that stay in the tile memory of a GPU that has one take no other memory.
                attachment | TextureUsages::TRANSIENT_ATTACHMENT
            } else {
                attachment
            };
            texture("packed_ycocg_multisampled", packed.samples, usage)
        }),
        samples_are_read,
    }
}

/// Replaces the texture for the background of transmissive objects, which the resolve writes in HDR.
///
/// Bevy's own texture for it can only be copied to, and has the format of the display if the camera has
/// no `Hdr`.
pub(super) fn replace_transmission_textures(
    mut views: Query<
        (
            &mut ViewTransmissionTexture,
            &ExtractedView,
            &ExtractedCamera,
        ),
        With<PackedView>,
    >,
    phases: Res<ViewSortedRenderPhases<Transmissive3d>>,
    mut cache: ResMut<TextureCache>,
    device: Res<RenderDevice>,
) {
    let mut shared: HashMap<_, CachedTexture> = HashMap::default();
    for (mut transmission, view, camera) in &mut views {
        let used = phases
            .get(&view.retained_view_entity)
            .is_some_and(|phase| !phase.items.is_empty());
        let Some(size) = camera.physical_target_size.filter(|_| used) else {
            continue;
        };
        let texture = shared.entry(camera.target.clone()).or_insert_with(|| {
            let descriptor = TextureDescriptor {
                label: Some("packed_ycocg_transmission"),
                size: size.to_extents(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: TRANSMISSION_FORMAT,
                usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            };
            cache.get(&device, descriptor)
        });
        transmission.texture = texture.texture.clone();
        transmission.view = texture.default_view.clone();
    }
}

/// Publishes the reports on all cameras with a quality, with the memory of their colour textures as allocated.
pub(super) fn publish_reports(
    views: Query<(
        &MainEntity,
        &ExtractedCamera,
        Option<&ViewTarget>,
        Option<&PackedTextures>,
    )>,
    mut decisions: ResMut<Decisions>,
    reports: Res<RenderedReports>,
    adapter: Res<RenderAdapterInfo>,
) {
    if decisions.0.is_empty() {
        return;
    }
    let is_free = |texture: &Texture| {
        let usage = texture.usage();
        adapter.transient_saves_memory == Some(true)
            && usage.contains(TextureUsages::TRANSIENT_ATTACHMENT)
    };
    let packed_bytes =
        |texture: Option<&CachedTexture>| match texture.map(|texture| &texture.texture) {
            Some(texture) if !is_free(texture) => bytes(texture),
            _ => 0,
        };
    let mut rendered = EntityHashMap::default();
    for (main_entity, camera, target, packed) in &views {
        // The window is not there yet.
        if target.is_none() && draws_colors(camera) {
            continue;
        }
        if let Some((state, refused)) = decisions.0.remove(&main_entity.id()) {
            let memory = ColorMemory {
                packed: packed_bytes(packed.and_then(|p| p.single_sampled.as_ref())),
                packed_multisampled: packed_bytes(packed.and_then(|p| p.multisampled.as_ref())),
                main: target.map_or(0, |t| {
                    bytes(t.main_texture()) + bytes(t.main_texture_other())
                }),
                main_multisampled: target
                    .and_then(ViewTarget::sampled_main_texture)
                    .map_or(0, bytes),
            };
            let report = FrameBufferReport {
                state,
                refused,
                memory,
            };
            rendered.insert(main_entity.id(), report);
        }
    }
    reports.publish(rendered);
}

fn bytes(texture: &Texture) -> u64 {
    let size = texture.size();
    let texels = u64::from(size.width) * u64::from(size.height) * u64::from(texture.sample_count());
    let texel_bytes = texture.format().block_copy_size(None).unwrap_or(0);
    texels * u64::from(texel_bytes)
}

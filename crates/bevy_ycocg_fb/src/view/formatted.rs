//! The views with another format, what Bevy sees of them, and the packed textures.
//!
//! All of Bevy's passes and textures take their format from the view, so a view in `Rg11b10Ufloat` has this format
//! throughout, and nothing else is replaced but the pass of temporal anti-aliasing ([`taa`](crate::pass::taa)), whose
//! history needs an alpha channel.
//!
//! The `ViewTarget` of a packed view and all effects keep the format of the camera, and the `ViewTarget` is
//! single-sampled, because only the packed texture is multisampled. While mesh pipeline keys are made and phases are
//! queued, a packed view has the format of its packed texture.
//!
//! The keys of both have a flag, so that they differ from a view whose target happens to have that format.

use bevy::{
    camera::MsaaWriteback,
    ecs::entity::{EntityHashMap, EntityHashSet},
    image::ToExtents,
    pbr::{MeshPipelineKey, Transmissive3d, ViewKeyCache, ViewTransmissionTexture},
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_phase::ViewSortedRenderPhases,
        render_resource::{TextureDescriptor, TextureDimension, TextureFormat, TextureUsages},
        renderer::RenderDevice,
        sync_world::MainEntity,
        texture::{CachedTexture, TextureCache},
        view::{ExtractedView, Msaa},
    },
};

use super::conditions::CandidateItem;
use crate::{
    material::PACKED_KEY,
    pass::{
        main_pass::PackedClear,
        resolve::{PackedResolve, ResolveBindGroup},
    },
    settings::{MsaaResolve, PackedFormat, YCoCgFrameBuffer},
};

/// Filter of the views with another format.
pub(crate) type Formatted = Or<(With<PackedView>, With<Rg11b10UfloatView>)>;

/// Component of a view that packs.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PackedView {
    pub settings: YCoCgFrameBuffer,
    pub format: PackedFormat,
    /// Number of samples per pixel.
    pub samples: u32,
    /// Whether the hardware resolves the samples; otherwise the resolve shader reads them.
    pub hardware_resolve: bool,
    /// Whether the resolve includes tone mapping, because no later pass of Bevy does it.
    pub tone_map: bool,
}

impl PackedView {
    pub(super) fn new(
        candidate: &CandidateItem,
        settings: YCoCgFrameBuffer,
        has_hardware_resolve: bool,
    ) -> Self {
        let samples = candidate.msaa.samples();
        let is_unorm8 = settings.format == PackedFormat::Unorm8;
        Self {
            settings,
            format: settings.format,
            samples,
            hardware_resolve: samples > 1
                && has_hardware_resolve
                && (settings.msaa_resolve == MsaaResolve::Box || is_unorm8),
            tone_map: !candidate.camera.hdr && !is_unorm8,
        }
    }

    /// Whether the resolve shader averages the samples of each pixel in linear light, beside the hardware's mean of
    /// their codes.
    pub(crate) fn has_linear_light(&self) -> bool {
        self.hardware_resolve && self.format == PackedFormat::Unorm8
    }
}

/// The components of a view that packs.
pub(super) type PackedComponents = (
    PackedView,
    PackedTextures,
    PackedClear,
    PackedResolve,
    ResolveBindGroup,
);

/// Component of a view that Bevy draws in `Rg11b10Ufloat`.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Rg11b10UfloatView;

/// Replaces the format of the views, which Bevy extracts anew in every frame, and of those of the user interface
/// over them.
pub(super) fn set_rg11b10ufloat_formats(
    cameras: Query<&MainEntity, With<Rg11b10UfloatView>>,
    mut views: Query<&mut ExtractedView>,
) {
    if cameras.is_empty() {
        return;
    }
    let cameras: EntityHashSet = cameras.iter().map(MainEntity::id).collect();
    for mut view in &mut views {
        if cameras.contains(&view.retained_view_entity.main_entity.id()) {
            view.target_format = TextureFormat::Rg11b10Ufloat;
        }
    }
}

/// The original formats of the views while they are replaced.
#[derive(Resource, Default)]
pub(super) struct OriginalFormats(EntityHashMap<TextureFormat>);

pub(super) fn set_packed_formats(
    mut views: Query<(Entity, &mut ExtractedView, &PackedView)>,
    mut original: ResMut<OriginalFormats>,
) {
    for (entity, mut view, packed) in &mut views {
        original.0.insert(entity, view.target_format);
        view.target_format = packed.format.texture_format();
    }
}

pub(super) fn restore_formats(
    mut views: Query<&mut ExtractedView>,
    mut original: ResMut<OriginalFormats>,
) {
    for (entity, format) in original.0.drain() {
        if let Ok(mut view) = views.get_mut(entity) {
            view.target_format = format;
        }
    }
}

/// Sets the flag in the keys of views with another format.
pub(super) fn mark_keys(
    views: Query<&ExtractedView, Formatted>,
    keys: Option<ResMut<ViewKeyCache>>,
) {
    let Some(mut keys) = keys else {
        return;
    };
    for view in &views {
        if let Some(key) = keys.get_mut(&view.retained_view_entity) {
            *key |= MeshPipelineKey::from_bits_retain(PACKED_KEY);
        }
    }
}

/// Removes the flag before Bevy compares the keys with those of this frame: if they differed, Bevy would
/// specialize all pipelines again.
pub(super) fn unmark_keys(keys: Option<ResMut<ViewKeyCache>>) {
    for key in keys
        .into_iter()
        .flat_map(|keys| keys.into_inner().values_mut())
    {
        *key = MeshPipelineKey::from_bits_retain(key.bits() & !PACKED_KEY);
    }
}

/// The original sample counts of the views while they are replaced.
#[derive(Resource, Default)]
pub(super) struct OriginalMsaa(EntityHashMap<Msaa>);

pub(super) fn disable_msaa(
    mut views: Query<(Entity, &mut Msaa, &mut ExtractedCamera), With<PackedView>>,
    mut original: ResMut<OriginalMsaa>,
) {
    for (entity, mut msaa, mut camera) in &mut views {
        original.0.insert(entity, *msaa);
        *msaa = Msaa::Off;
        // The view has no multisampled texture to write back to.
        camera.msaa_writeback = MsaaWriteback::Off;
    }
}

pub(super) fn restore_msaa(mut views: Query<&mut Msaa>, mut original: ResMut<OriginalMsaa>) {
    for (entity, samples) in original.0.drain() {
        if let Ok(mut msaa) = views.get_mut(entity) {
            *msaa = samples;
        }
    }
}

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
    transmissive_phases: Res<ViewSortedRenderPhases<Transmissive3d>>,
) {
    let mut shared: HashMap<_, PackedTextures> = HashMap::default();
    for (entity, packed, camera, view) in &views {
        let Some(size) = camera.physical_target_size else {
            commands.entity(entity).remove::<PackedTextures>();
            continue;
        };
        let is_one_pass = !has_transmissive_items(&transmissive_phases, view);
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

/// A texture that is drawn to and read.
pub(crate) fn target_descriptor(
    label: &'static str,
    size: UVec2,
    format: TextureFormat,
    sample_count: u32,
) -> TextureDescriptor<'static> {
    TextureDescriptor {
        label: Some(label),
        size: size.to_extents(),
        mip_level_count: 1,
        sample_count,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    }
}

pub(crate) fn has_transmissive_items(
    phases: &ViewSortedRenderPhases<Transmissive3d>,
    view: &ExtractedView,
) -> bool {
    let phase = phases.get(&view.retained_view_entity);
    phase.is_some_and(|phase| !phase.items.is_empty())
}

fn create(
    cache: &mut TextureCache,
    device: &RenderDevice,
    packed: &PackedView,
    size: UVec2,
    is_one_pass: bool,
) -> PackedTextures {
    let mut texture = |label, sample_count, usage| {
        let format = packed.format.texture_format();
        let descriptor = TextureDescriptor {
            usage,
            ..target_descriptor(label, size, format, sample_count)
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
        let used = has_transmissive_items(&phases, view);
        let Some(size) = camera.physical_target_size.filter(|_| used) else {
            continue;
        };
        let texture = shared.entry(camera.target.clone()).or_insert_with(|| {
            let label = "packed_ycocg_transmission";
            let descriptor = target_descriptor(label, size, TRANSMISSION_FORMAT, 1);
            cache.get(&device, descriptor)
        });
        transmission.texture = texture.texture.clone();
        transmission.view = texture.default_view.clone();
    }
}

//! The views with another format, and what Bevy sees of them.
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
    pbr::{MeshPipelineKey, ViewKeyCache},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::TextureFormat,
        sync_world::MainEntity,
        view::{ExtractedView, Msaa},
    },
};

use super::conditions::{CandidateItem, FormatSupport};
use crate::{
    material::pipeline::PACKED_KEY,
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
        support: FormatSupport,
    ) -> Self {
        let samples = candidate.msaa.samples();
        let is_unorm8 = settings.format == PackedFormat::Unorm8;
        Self {
            settings,
            format: settings.format,
            samples,
            hardware_resolve: samples > 1
                && support.hardware_resolve
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

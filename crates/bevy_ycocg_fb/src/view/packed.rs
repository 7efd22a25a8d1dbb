//! The cameras that pack.

use bevy::{camera::ClearColorConfig, ecs::entity::EntityHashMap, prelude::*};

use super::{
    candidate::{Cameras, Candidate, CandidateItem, MainWorldState},
    capabilities::FormatSupport,
};
use crate::{
    fallback::FallbackReason,
    settings::{MsaaResolve, PackedFormat, YCoCgFrameBuffer},
};

/// Component of a view that packs.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PackedView {
    pub settings: YCoCgFrameBuffer,
    /// The format of the settings.
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
        format: PackedFormat,
        support: FormatSupport,
    ) -> Self {
        let settings = *candidate.settings;
        let samples = candidate.msaa.samples();
        Self {
            settings,
            format,
            samples,
            hardware_resolve: samples > 1
                && support.hardware_resolve
                && (settings.msaa_resolve == MsaaResolve::Box || format == PackedFormat::Unorm8),
            tone_map: !candidate.camera.hdr && format != PackedFormat::Unorm8,
        }
    }

    /// Whether the resolve shader averages the samples of each pixel in linear light, beside the hardware's mean of
    /// their codes.
    pub(crate) fn has_linear_light(&self) -> bool {
        self.hardware_resolve && self.format == PackedFormat::Unorm8
    }
}

/// Pipelines that cannot pack, by the camera that drew them, with the camera's settings.
#[derive(Resource, Debug, Default)]
pub(crate) struct UnpackedPipelines {
    pub by_camera: EntityHashMap<(YCoCgFrameBuffer, String)>,
    /// Generation of the shaders for which `by_camera` is valid.
    generation: u64,
}

impl UnpackedPipelines {
    /// Forgets what is not current: a camera whose component or settings changed is tried again; all cameras
    /// are when a shader changed.
    pub(super) fn keep_current(&mut self, candidates: &Query<Candidate>, generation: u64) {
        if self.generation != generation {
            self.generation = generation;
            self.by_camera.clear();
        }
        self.by_camera.retain(|&main_entity, (settings, _)| {
            candidates
                .iter()
                .any(|c| c.main_entity.id() == main_entity && c.settings == settings)
        });
    }
}

/// Returns the first reason for which the camera cannot pack.
pub(super) fn packed_reason(
    candidate: &CandidateItem,
    format: PackedFormat,
    cameras: &Cameras,
    state: &MainWorldState,
    unpacked: &UnpackedPipelines,
) -> Option<FallbackReason> {
    let camera = candidate.camera;
    let unpacked = unpacked.by_camera.get(&candidate.main_entity.id());
    // The cause precedes its consequences: screen-space reflections require the deferred prepass.
    let reasons = [
        state.refused.clone().map(FallbackReason::PatchRefused),
        candidate
            .reflections
            .then_some(FallbackReason::ScreenSpaceReflections),
        candidate
            .deferred
            .then_some(FallbackReason::DeferredPrepass),
        candidate
            .transparency
            .then_some(FallbackReason::OrderIndependentTransparency),
        candidate.atmosphere.then_some(FallbackReason::Atmosphere),
        state.wireframes.then_some(FallbackReason::Wireframes),
        candidate
            .resolution_override
            .then_some(FallbackReason::ResolutionOverride),
        matches!(camera.clear_color, ClearColorConfig::None).then_some(FallbackReason::NoClear),
        is_continued(candidate, cameras).then_some(FallbackReason::ContinuedByMultisampled),
        (format == PackedFormat::Unorm8 && camera.hdr).then_some(FallbackReason::Unorm8WithHdr),
        unpacked.map(|(_, name)| FallbackReason::UnpackedPipeline(name.clone())),
    ];
    reasons.into_iter().flatten().next()
}

/// Whether a later camera continues in the multisampled texture of this one, which a packed camera does
/// not write.
fn is_continued(candidate: &CandidateItem, cameras: &Cameras) -> bool {
    candidate.msaa.samples() > 1
        && cameras.iter().any(|(entity, other, _)| {
            entity != candidate.entity
                && other.target == candidate.camera.target
                && other.order >= candidate.camera.order
                && matches!(other.clear_color, ClearColorConfig::None)
        })
}

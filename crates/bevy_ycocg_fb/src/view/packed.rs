//! The cameras that pack.

use bevy::prelude::*;

use super::{
    candidate::{CandidateItem, MainWorldState},
    capabilities::FormatSupport,
    stack::{Layer, is_continued},
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

/// Returns the first reason for which the camera alone cannot pack.
pub(super) fn packed_reason(
    candidate: &CandidateItem,
    format: PackedFormat,
    state: &MainWorldState,
    main_pass_system: Option<&str>,
) -> Option<FallbackReason> {
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
        state.wireframes.then_some(FallbackReason::Wireframes),
        candidate
            .resolution_override
            .then_some(FallbackReason::ResolutionOverride),
        candidate.has_no_clear().then_some(FallbackReason::NoClear),
        (format == PackedFormat::Unorm8 && candidate.camera.hdr)
            .then_some(FallbackReason::Unorm8WithHdr),
        main_pass_system.map(|name| FallbackReason::MainPassSystem(name.into())),
    ];
    reasons.into_iter().flatten().next()
}

/// Returns the reason for which the camera cannot pack beside the other cameras of its target.
///
/// A packed camera writes a single-sampled `ViewTarget`, in which no later camera finds samples.
pub(super) fn packed_stack_reason(layer: &Layer, layers: &[Layer]) -> Option<FallbackReason> {
    let sharing = layers.iter().filter(|other| other.shares(layer));
    if layer.continues(sharing.clone()) {
        return Some(FallbackReason::MsaaWriteback);
    }
    let is_multisampled = layer.samples > 1;
    // A single-sampled camera that does not clear would find the picture of this one in place of its own.
    let would_be_continued = layers.iter().any(|other| {
        let single_sampled = Layer {
            samples: other.samples,
            ..layer.clone()
        };
        other.samples == 1 && other.has_no_clear && other.shares(&single_sampled)
    });
    (is_multisampled && (is_continued(sharing) || would_be_continued))
        .then_some(FallbackReason::ContinuedByMultisampled)
}

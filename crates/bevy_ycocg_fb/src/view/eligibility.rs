//! The choice of the cameras that pack.

use bevy::{
    camera::{ClearColorConfig, MainPassResolutionOverride},
    core_pipeline::{Core3d, oit::OrderIndependentTransparencySettings, prepass::DeferredPrepass},
    ecs::{entity::EntityHashMap, query::QueryData, schedule::ScheduleLabel},
    pbr::{ExtractedAtmosphere, ScreenSpaceReflectionsUniform, wireframe::Mesh3dWireframe},
    platform::collections::HashSet,
    prelude::*,
    render::{
        Extract,
        camera::ExtractedCamera,
        renderer::{RenderAdapter, RenderDevice},
        sync_world::MainEntity,
        view::{ExtractedView, Msaa},
    },
};
use bevy_frugal_hooks::ShaderPatches;

use super::capabilities::FormatSupport;
use crate::{
    fallback::FallbackReason,
    material::{detect::PackingShaders, patches::REQUIRED},
    report::{CameraState, FrameBufferReports},
    settings::{MsaaResolve, PackedFormat, YCoCgFrameBuffer},
};

/// Component of a view that packs. The rest of this crate changes only views with it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PackedView {
    pub settings: YCoCgFrameBuffer,
    /// Number of samples per pixel.
    pub samples: u32,
    /// Whether the hardware resolves the samples; otherwise the resolve shader reads them.
    pub hardware_resolve: bool,
    /// Whether the resolve includes tone mapping, because no later pass of Bevy does it.
    pub tone_map: bool,
}

/// State of the main world that the render world uses.
#[derive(Resource, Debug, Default)]
pub(super) struct MainWorldState {
    patched: bool,
    refused: Option<String>,
    wireframes: bool,
}

pub(super) fn extract_main_world_state(
    mut state: ResMut<MainWorldState>,
    patches: Extract<Option<Res<ShaderPatches>>>,
    wireframes: Extract<Query<(), With<Mesh3dWireframe>>>,
) {
    state.wireframes = !wireframes.is_empty();
    if let Some(patches) = patches.as_ref() {
        state.patched = patches.all_applied(REQUIRED);
        state.refused = patches
            .refused(REQUIRED)
            .map(|(name, error)| format!("the shader patch `{name}` does not fit: {error}"));
    }
}

/// Pipelines that cannot pack, by the camera that drew them, with the camera's settings.
#[derive(Resource, Debug, Default)]
pub(crate) struct UnpackedPipelines {
    pub by_camera: EntityHashMap<(YCoCgFrameBuffer, String)>,
    /// Generation of the shaders for which `by_camera` is valid.
    generation: u64,
}

/// The warnings that were already logged.
#[derive(Resource, Debug, Default)]
pub(super) struct LoggedFallbacks(HashSet<(Entity, FallbackReason)>);

#[derive(QueryData)]
pub(super) struct Candidate {
    entity: Entity,
    main_entity: &'static MainEntity,
    settings: &'static YCoCgFrameBuffer,
    view: &'static ExtractedView,
    camera: &'static ExtractedCamera,
    msaa: &'static Msaa,
    deferred: Has<DeferredPrepass>,
    reflections: Has<ScreenSpaceReflectionsUniform>,
    transparency: Has<OrderIndependentTransparencySettings>,
    atmosphere: Has<ExtractedAtmosphere>,
    resolution_override: Has<MainPassResolutionOverride>,
}

/// Inserts [`PackedView`] for the cameras that can pack, and removes it from the others.
pub(super) fn select_packed_views(
    mut commands: Commands,
    candidates: Query<Candidate>,
    cameras: Query<(Entity, &ExtractedCamera)>,
    former: Query<(Entity, &MainEntity), (With<PackedView>, Without<YCoCgFrameBuffer>)>,
    state: Res<MainWorldState>,
    mut unpacked: ResMut<UnpackedPipelines>,
    mut logged: ResMut<LoggedFallbacks>,
    clear_color: Res<ClearColor>,
    adapter: Res<RenderAdapter>,
    device: Res<RenderDevice>,
    shaders: Res<PackingShaders>,
    reports: Res<FrameBufferReports>,
) {
    for (entity, _) in &former {
        commands.entity(entity).remove::<PackedView>();
    }
    reports.clear();
    // A camera whose component or settings changed is tried again; all cameras are when a shader
    // changed.
    if unpacked.generation != shaders.generation() {
        unpacked.generation = shaders.generation();
        unpacked.by_camera.clear();
    }
    unpacked.by_camera.retain(|&main_entity, (settings, _)| {
        candidates
            .iter()
            .any(|c| c.main_entity.id() == main_entity && c.settings == settings)
    });
    for candidate in &candidates {
        let main_entity = candidate.main_entity.id();
        if !state.patched && state.refused.is_none() {
            // Bevy's shaders are still loading, as in the first frames.
            commands.entity(candidate.entity).remove::<PackedView>();
            continue;
        }
        let view = fallback_reason(&candidate, &cameras, &state, &unpacked, &clear_color)
            .map_or(Ok(()), Err)
            .and_then(|()| packed_view(&candidate, &adapter, &device));
        match view {
            Ok(view) => {
                commands.entity(candidate.entity).insert(view);
                reports.set_state(main_entity, CameraState::Packed);
            }
            Err(reason) => {
                commands.entity(candidate.entity).remove::<PackedView>();
                reports.set_state(main_entity, CameraState::Fallback(reason.clone()));
                if logged.0.insert((main_entity, reason.clone())) {
                    warn!("camera {main_entity} does not use its YCoCgFrameBuffer: {reason}");
                }
            }
        }
    }
}

/// Returns the first reason for which the camera cannot pack.
fn fallback_reason(
    candidate: &CandidateItem,
    cameras: &Query<(Entity, &ExtractedCamera)>,
    state: &MainWorldState,
    unpacked: &UnpackedPipelines,
    clear_color: &ClearColor,
) -> Option<FallbackReason> {
    let camera = candidate.camera;
    let clear = match camera.clear_color {
        ClearColorConfig::Default => Some(clear_color.0),
        ClearColorConfig::Custom(color) => Some(color),
        ClearColorConfig::None => None,
    };
    let unpacked = unpacked.by_camera.get(&candidate.main_entity.id());
    // The cause precedes its consequences: screen-space reflections require the deferred prepass.
    let reasons = [
        (camera.schedule != Core3d.intern()).then_some(FallbackReason::Not3d),
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
        clear.is_none().then_some(FallbackReason::NoClear),
        is_continued(candidate, cameras).then_some(FallbackReason::ContinuedByMultisampled),
        clear
            .is_some_and(|color| color.alpha() < 1.0)
            .then_some(FallbackReason::TransparentBackground),
        (candidate.settings.format == PackedFormat::Unorm8 && camera.hdr)
            .then_some(FallbackReason::Unorm8WithHdr),
        unpacked.map(|(_, name)| FallbackReason::UnpackedPipeline(name.clone())),
    ];
    reasons.into_iter().flatten().next()
}

/// Whether a later camera continues in the multisampled texture of this one, which a packed camera does
/// not write.
fn is_continued(candidate: &CandidateItem, cameras: &Query<(Entity, &ExtractedCamera)>) -> bool {
    candidate.msaa.samples() > 1
        && cameras.iter().any(|(entity, other)| {
            entity != candidate.entity
                && other.target == candidate.camera.target
                && other.order >= candidate.camera.order
                && matches!(other.clear_color, ClearColorConfig::None)
        })
}

fn packed_view(
    candidate: &CandidateItem,
    adapter: &RenderAdapter,
    device: &RenderDevice,
) -> Result<PackedView, FallbackReason> {
    let settings = *candidate.settings;
    let samples = candidate.msaa.samples();
    let support = FormatSupport::of(settings.format, samples, adapter, device)?;
    Ok(PackedView {
        settings,
        samples,
        hardware_resolve: samples > 1
            && support.hardware_resolve
            && settings.msaa_resolve == MsaaResolve::Box,
        tone_map: !candidate.camera.hdr && settings.format != PackedFormat::Unorm8,
    })
}

//! The choice of the cameras that use their format.

use bevy::{
    camera::ClearColorConfig,
    core_pipeline::Core3d,
    ecs::schedule::ScheduleLabel,
    platform::collections::HashSet,
    prelude::*,
    render::{
        renderer::{RenderAdapter, RenderDevice},
        view::ExtractedView,
    },
};

use super::{
    candidate::{Cameras, Candidate, CandidateItem, MainWorldState},
    capabilities::FormatSupport,
    packed::{PackedView, UnpackedPipelines, packed_reason},
    rg11b10ufloat::{Rg11b10UfloatView, rg11b10ufloat_reason},
};
use crate::{
    fallback::FallbackReason,
    material::detect::PackingShaders,
    report::{CameraState, FrameBufferReports},
    settings::{FrameBufferFormat, YCoCgFrameBuffer},
};

/// The warnings that were already logged.
#[derive(Resource, Debug, Default)]
pub(super) struct LoggedFallbacks(HashSet<(Entity, FallbackReason)>);

/// Filter of the views with another format.
pub(super) type Formatted = Or<(With<PackedView>, With<Rg11b10UfloatView>)>;

/// Inserts [`PackedView`] or [`Rg11b10UfloatView`] for the cameras that can use their format, and removes them
/// from the others.
pub(super) fn select_views(
    mut commands: Commands,
    candidates: Query<Candidate>,
    cameras: Cameras,
    views: Query<&ExtractedView>,
    former: Query<Entity, (Formatted, Without<YCoCgFrameBuffer>)>,
    state: Res<MainWorldState>,
    mut unpacked: ResMut<UnpackedPipelines>,
    mut logged: ResMut<LoggedFallbacks>,
    clear_color: Res<ClearColor>,
    adapter: Res<RenderAdapter>,
    device: Res<RenderDevice>,
    shaders: Res<PackingShaders>,
    reports: Res<FrameBufferReports>,
) {
    for entity in &former {
        commands
            .entity(entity)
            .remove::<(PackedView, Rg11b10UfloatView)>();
    }
    reports.clear();
    unpacked.keep_current(&candidates, shaders.generation());
    for candidate in &candidates {
        let mut entity = commands.entity(candidate.entity);
        if !state.patched && state.refused.is_none() {
            // Bevy's shaders are still loading, as in the first frames.
            entity.remove::<(PackedView, Rg11b10UfloatView)>();
            continue;
        }
        let format = candidate.settings.format;
        let reason = common_reason(&candidate, &clear_color).or_else(|| match format {
            FrameBufferFormat::Packed(format) => {
                packed_reason(&candidate, format, &cameras, &state, &unpacked)
            }
            FrameBufferFormat::Rg11b10Ufloat => rg11b10ufloat_reason(&candidate, &cameras, &views),
        });
        let samples = candidate.msaa.samples();
        let support = reason.map_or_else(
            || FormatSupport::of(format, samples, &adapter, &device),
            Err,
        );
        let main_entity = candidate.main_entity.id();
        match support {
            Ok(support) => {
                let state = match format {
                    FrameBufferFormat::Packed(format) => {
                        let view = PackedView::new(&candidate, format, support);
                        entity.remove::<Rg11b10UfloatView>().insert(view);
                        CameraState::Packed
                    }
                    FrameBufferFormat::Rg11b10Ufloat => {
                        entity.remove::<PackedView>().insert(Rg11b10UfloatView);
                        CameraState::Rg11b10Ufloat
                    }
                };
                reports.set_state(main_entity, state);
            }
            Err(reason) => {
                entity.remove::<(PackedView, Rg11b10UfloatView)>();
                reports.set_state(main_entity, CameraState::Fallback(reason.clone()));
                if logged.0.insert((main_entity, reason.clone())) {
                    warn!("camera {main_entity} does not use its YCoCgFrameBuffer: {reason}");
                }
            }
        }
    }
}

/// Returns the first reason for which the camera cannot use any format.
fn common_reason(candidate: &CandidateItem, clear_color: &ClearColor) -> Option<FallbackReason> {
    let camera = candidate.camera;
    let clear = match camera.clear_color {
        ClearColorConfig::Default => Some(clear_color.0),
        ClearColorConfig::Custom(color) => Some(color),
        ClearColorConfig::None => None,
    };
    if camera.schedule != Core3d.intern() {
        Some(FallbackReason::Not3d)
    } else if clear.is_some_and(|color| color.alpha() < 1.0) {
        Some(FallbackReason::TransparentBackground)
    } else {
        None
    }
}

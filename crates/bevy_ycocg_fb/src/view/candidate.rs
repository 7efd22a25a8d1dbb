//! The cameras, and what decides whether they can use a format.

use bevy::{
    camera::{
        CameraMainTextureUsages, ClearColorConfig, MainPassResolutionOverride,
        NormalizedRenderTarget,
    },
    core_pipeline::{
        Core2d, Core3d, oit::OrderIndependentTransparencySettings, prepass::DeferredPrepass,
    },
    ecs::{query::QueryData, schedule::ScheduleLabel},
    pbr::{ExtractedAtmosphere, ScreenSpaceReflectionsUniform, wireframe::Mesh3dWireframe},
    prelude::*,
    render::{
        Extract,
        camera::ExtractedCamera,
        sync_world::{MainEntity, RenderEntity},
        view::{ExtractedView, Msaa},
    },
};
use bevy_frugal_hooks::ShaderPatches;

use crate::{
    material::patches::REQUIRED,
    settings::{DefaultFrameBufferQuality, FrameBufferQuality},
};

/// State of the main world that the render world uses.
#[derive(Resource, Debug, Default)]
pub(super) struct MainWorldState {
    pub patched: bool,
    pub refused: Option<String>,
    pub wireframes: bool,
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

/// Extracts the quality of each camera: its own, or that of the app for cameras in 3D.
pub(super) fn extract_qualities(
    mut commands: Commands,
    default: Extract<Option<Res<DefaultFrameBufferQuality>>>,
    cameras: Extract<
        Query<(RenderEntity, Option<&FrameBufferQuality>, Has<Camera3d>), With<Camera>>,
    >,
    extracted: Query<&FrameBufferQuality>,
) {
    for (entity, own, is_3d) in &cameras {
        let default = default.as_ref().filter(|_| is_3d).map(|default| default.0);
        let quality = own.copied().or(default);
        let former = extracted.get(entity).ok().copied();
        match quality {
            Some(quality) if former != Some(quality) => {
                commands.entity(entity).insert(quality);
            }
            None if former.is_some() => {
                commands.entity(entity).remove::<FrameBufferQuality>();
            }
            _ => {}
        }
    }
}

/// Whether the camera draws colours, and not only depth.
pub(super) fn draws_colors(camera: &ExtractedCamera) -> bool {
    !matches!(camera.target, Some(NormalizedRenderTarget::None { .. }))
}

/// A camera, with or without a quality.
#[derive(QueryData)]
pub(super) struct Candidate {
    pub entity: Entity,
    pub main_entity: &'static MainEntity,
    pub quality: Option<&'static FrameBufferQuality>,
    pub view: &'static ExtractedView,
    pub camera: &'static ExtractedCamera,
    pub msaa: &'static Msaa,
    pub usages: &'static CameraMainTextureUsages,
    pub deferred: Has<DeferredPrepass>,
    pub reflections: Has<ScreenSpaceReflectionsUniform>,
    pub transparency: Has<OrderIndependentTransparencySettings>,
    pub atmosphere: Has<ExtractedAtmosphere>,
    pub resolution_override: Has<MainPassResolutionOverride>,
}

impl CandidateItem<'_, '_> {
    pub(super) fn is_3d(&self) -> bool {
        self.camera.schedule == Core3d.intern()
    }

    pub(super) fn is_2d(&self) -> bool {
        self.camera.schedule == Core2d.intern()
    }

    /// Whether the camera keeps what is in its target whatever other cameras do.
    pub(super) fn has_no_clear(&self) -> bool {
        matches!(self.camera.clear_color, ClearColorConfig::None)
    }

    /// Whether the camera is cleared to a colour with an alpha below 1.
    pub(super) fn is_transparent(&self, clear_color: &ClearColor) -> bool {
        let color = match self.camera.clear_color {
            ClearColorConfig::Default => Some(clear_color.0),
            ClearColorConfig::Custom(color) => Some(color),
            ClearColorConfig::None => None,
        };
        color.is_some_and(|color| color.alpha() < 1.0)
    }
}

//! The cameras with the component, and what decides whether they can use its format.

use bevy::{
    camera::MainPassResolutionOverride,
    core_pipeline::{oit::OrderIndependentTransparencySettings, prepass::DeferredPrepass},
    ecs::query::QueryData,
    pbr::{ExtractedAtmosphere, ScreenSpaceReflectionsUniform, wireframe::Mesh3dWireframe},
    prelude::*,
    render::{
        Extract,
        camera::ExtractedCamera,
        sync_world::MainEntity,
        view::{ExtractedView, Msaa},
    },
};
use bevy_frugal_hooks::ShaderPatches;

use crate::{material::patches::REQUIRED, settings::YCoCgFrameBuffer};

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

/// All cameras, with or without the component.
pub(super) type Cameras<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static ExtractedCamera,
        Option<&'static YCoCgFrameBuffer>,
    ),
>;

/// A camera with the component.
#[derive(QueryData)]
pub(super) struct Candidate {
    pub entity: Entity,
    pub main_entity: &'static MainEntity,
    pub settings: &'static YCoCgFrameBuffer,
    pub view: &'static ExtractedView,
    pub camera: &'static ExtractedCamera,
    pub msaa: &'static Msaa,
    pub deferred: Has<DeferredPrepass>,
    pub reflections: Has<ScreenSpaceReflectionsUniform>,
    pub transparency: Has<OrderIndependentTransparencySettings>,
    pub atmosphere: Has<ExtractedAtmosphere>,
    pub resolution_override: Has<MainPassResolutionOverride>,
}

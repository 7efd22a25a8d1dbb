//! The formats that drawing a camera has shown to be impossible.
//!
//! When the renderer refuses a frame that has another format, and its error is about that format, the cameras that had
//! it are drawn in Bevy's from the next frame on. Bevy's default handler ends the app on such an error. All other errors
//! go to the handler that the app has, and so does a second one, since no camera has the format then.

use std::ptr::fn_addr_eq;

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    render::{
        error_handler::{ErrorType, RenderError, RenderErrorHandler, RenderErrorPolicy},
        sync_world::MainEntity,
    },
};

use super::{
    conditions::Candidate,
    formatted::{PackedView, Rg11b10UfloatView},
};
use crate::{
    material::detect::PackingShaders,
    report::FallbackReason,
    settings::{FrameBufferFormat, FrameBufferQuality},
};

/// What was refused, by camera in the main world. A camera is tried again when its quality changes, and when the
/// shader that did not pack does.
#[derive(Resource, Debug, Default)]
pub(crate) struct Refusals {
    formats: HashMap<(Entity, FrameBufferFormat), Refusal>,
    /// Generation of the shaders for which `formats` is valid.
    generation: u64,
}

#[derive(Debug)]
struct Refusal {
    reason: FallbackReason,
    /// The shader that does not pack.
    shader: Option<AssetId<Shader>>,
    /// Quality of the camera, once it is known.
    quality: Option<Option<FrameBufferQuality>>,
}

impl Refusals {
    pub(crate) fn add(
        &mut self,
        camera: Entity,
        format: FrameBufferFormat,
        reason: FallbackReason,
        shader: Option<AssetId<Shader>>,
    ) {
        self.formats.entry((camera, format)).or_insert(Refusal {
            reason,
            shader,
            quality: None,
        });
    }

    pub(super) fn get(&self, camera: Entity, format: FrameBufferFormat) -> Option<FallbackReason> {
        self.formats
            .get(&(camera, format))
            .map(|refusal| refusal.reason.clone())
    }

    pub(super) fn keep_current(&mut self, candidates: &Query<Candidate>, shaders: &PackingShaders) {
        if self.formats.is_empty() {
            return;
        }
        let is_new = self.generation != shaders.generation();
        self.generation = shaders.generation();
        self.formats.retain(|&(camera, _), refusal| {
            let mut cameras = candidates.iter();
            let Some(candidate) = cameras.find(|c| c.main_entity.id() == camera) else {
                return false;
            };
            let quality = candidate.quality.copied();
            let packs_now = is_new
                && refusal
                    .shader
                    .is_some_and(|shader| shaders.contains(shader));
            *refusal.quality.get_or_insert(quality) == quality && !packs_now
        });
    }
}

type Handler = for<'a> fn(&'a RenderError, &'a mut World, &'a mut World) -> RenderErrorPolicy;

/// The handler of the app, which gets what is not ours.
#[derive(Resource)]
struct AppHandler(Handler);

/// Puts [`handle`] before the handler of the app, whenever the app has set one.
pub(super) fn install_error_handler(
    mut commands: Commands,
    handler: Option<ResMut<RenderErrorHandler>>,
) {
    if let Some(mut handler) = handler
        && !fn_addr_eq(handler.0, handle as Handler)
    {
        commands.insert_resource(AppHandler(handler.0));
        handler.0 = handle;
    }
}

fn handle<'a>(
    error: &'a RenderError,
    main_world: &'a mut World,
    render_world: &'a mut World,
) -> RenderErrorPolicy {
    if error.ty == ErrorType::Validation && refuse(&error.description, main_world, render_world) {
        return RenderErrorPolicy::Ignore;
    }
    match main_world.get_resource::<AppHandler>() {
        Some(&AppHandler(handler)) => handler(error, main_world, render_world),
        None => RenderErrorPolicy::StopRendering,
    }
}

/// Refuses the formats that the error is about. Returns whether a camera has any of them.
fn refuse(error: &str, main_world: &World, render_world: &mut World) -> bool {
    let mut views =
        render_world.query::<(&MainEntity, Option<&PackedView>, Has<Rg11b10UfloatView>)>();
    let refused: Vec<_> = views
        .iter(render_world)
        .filter_map(|(camera, packed, is_rg11b10ufloat)| {
            let format = match packed {
                Some(packed) => packed.format.into(),
                None if is_rg11b10ufloat => FrameBufferFormat::Rg11b10Ufloat,
                None => return None,
            };
            let is_multisampled = packed.is_some_and(|packed| packed.samples > 1);
            is_about(error, format, is_multisampled).then_some((camera.id(), format))
        })
        .collect();
    let mut refusals = render_world.resource_mut::<Refusals>();
    for &(camera, format) in &refused {
        let name = main_world.get::<Name>(camera);
        let name = name.map_or_else(|| camera.to_string(), |name| format!("`{name}`"));
        error!(
            "camera {name} is drawn in Bevy's format from now on: the renderer refused {format:?}. {error}"
        );
        let reason = FallbackReason::RefusedByRenderer(error.to_owned());
        refusals.add(camera, format, reason, None);
    }
    !refused.is_empty()
}

/// Whether an error names the format, or the samples of which a packed camera's target has only one.
fn is_about(error: &str, format: FrameBufferFormat, is_multisampled: bool) -> bool {
    let names = |text: &str| error.contains(text);
    match format {
        FrameBufferFormat::Rg11b10Ufloat => {
            names("Rg11b10Ufloat") || names("Rg11b10ufloat") || names("rg11b10ufloat")
        }
        FrameBufferFormat::Packed(packed) => {
            names(&format!("{:?}", packed.texture_format()))
                || names("packed_ycocg")
                || (is_multisampled && names("sample count"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::PackedFormat;

    #[test]
    fn errors_about_other_formats_are_not_ours() {
        let fixed = "In a CommandEncoder, label = 'post' Incompatible color attachments at indices [0]: the \
            RenderPass uses textures with formats [Some(Rg11b10Ufloat)] but the RenderPipeline with 'tint' label \
            uses attachments with formats [Some(Rgba16Float)]";
        let samples = "Incompatible sample count: the RenderPass uses textures with sample count 1 but the \
            RenderPipeline with 'tint' label uses attachments with format 4";
        let packed = FrameBufferFormat::Packed(PackedFormat::Float16);
        assert!(is_about(fixed, FrameBufferFormat::Rg11b10Ufloat, false));
        assert!(!is_about(fixed, packed, true));
        assert!(is_about(samples, packed, true));
        assert!(!is_about(samples, packed, false));
        assert!(!is_about(samples, FrameBufferFormat::Rg11b10Ufloat, false));
    }
}

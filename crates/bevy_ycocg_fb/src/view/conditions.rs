//! What decides whether a camera can use a format: the camera itself, the app, systems of other plugins, the adapter, and
//! what drawing it has shown to be impossible.

use std::ptr::fn_addr_eq;

use bevy::{
    camera::{
        CameraMainTextureUsages, ClearColorConfig, MainPassResolutionOverride,
        NormalizedRenderTarget,
    },
    core_pipeline::{
        Core2d, Core3d, Core3dSystems,
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        oit::{OrderIndependentTransparencySettings, resolve::node::oit_resolve},
        prepass::DeferredPrepass,
    },
    ecs::{
        query::QueryData,
        schedule::{InternedSystemSet, ScheduleLabel, Schedules, SystemSet},
    },
    pbr::{
        ExtractedAtmosphere, ScreenSpaceReflectionsUniform, deferred::deferred_lighting,
        main_transmissive_pass_3d, screen_space_reflections, wireframe::Mesh3dWireframe,
    },
    platform::collections::HashMap,
    prelude::*,
    render::{
        Extract,
        camera::ExtractedCamera,
        error_handler::{ErrorType, RenderError, RenderErrorHandler, RenderErrorPolicy},
        render_resource::{TextureFormatFeatureFlags, TextureFormatFeatures, TextureUsages},
        sync_world::{MainEntity, RenderEntity},
        view::{ExtractedView, Msaa},
    },
};
use bevy_frugal_hooks::ShaderPatches;

use super::formatted::{PackedView, Rg11b10UfloatView};
use crate::{
    material::{REQUIRED, detect::PackingShaders},
    report::{FallbackReason, camera_name},
    settings::{DefaultFrameBufferQuality, FrameBufferFormat, FrameBufferQuality},
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
        let previous = extracted.get(entity).ok().copied();
        match quality {
            Some(quality) if previous != Some(quality) => {
                commands.entity(entity).insert(quality);
            }
            None if previous.is_some() => {
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

/// This plugin's systems in the main pass.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct OwnMainPass;

/// The first system of another plugin in the main pass.
#[derive(Resource, Debug, Default)]
pub(super) struct MainPassSystems {
    foreign: Option<String>,
    /// The number of systems that were inspected.
    inspected: usize,
}

impl MainPassSystems {
    pub(super) fn foreign(&self) -> Option<&str> {
        self.foreign.as_deref()
    }
}

/// The systems that are replaced, or that do not draw for a packed camera, as sets.
fn known_systems() -> [InternedSystemSet; 7] {
    [
        main_opaque_pass_3d.into_system_set().intern(),
        main_transmissive_pass_3d.into_system_set().intern(),
        main_transparent_pass_3d.into_system_set().intern(),
        // Cameras that use these fall back.
        oit_resolve.into_system_set().intern(),
        deferred_lighting.into_system_set().intern(),
        screen_space_reflections.into_system_set().intern(),
        OwnMainPass.intern(),
    ]
}

/// Inspects the schedule after it was built, and whenever systems were added.
pub(super) fn find_main_pass_systems(
    schedules: Res<Schedules>,
    mut main_pass_systems: ResMut<MainPassSystems>,
) {
    let Some(schedule) = schedules.get(Core3d) else {
        return;
    };
    let count = schedule.systems_len();
    if count == main_pass_systems.inspected {
        return;
    }
    let keys_of = |set| schedule.graph().systems_in_set(set);
    let (Ok(main_pass), Ok(systems)) = (
        keys_of(Core3dSystems::MainPass.intern()),
        schedule.systems(),
    ) else {
        return;
    };
    main_pass_systems.inspected = count;
    let known: Vec<_> = known_systems()
        .into_iter()
        .filter_map(|set| keys_of(set).ok())
        .collect();
    let mut foreign = systems
        .filter(|(key, _)| main_pass.contains(key) && !known.iter().any(|keys| keys.contains(key)))
        .map(|(_, system)| system.name().to_string())
        .map(|name| match name.contains("::") {
            true => format!("`{name}`"),
            false => "a system (Bevy's feature `debug` shows its name)".into(),
        });
    main_pass_systems.foreign = foreign.next();
}

/// Returns whether the hardware can resolve samples of a format.
///
/// # Errors
/// Returns the feature that the adapter lacks as the reason of the fallback.
pub(super) fn hardware_resolve(
    format: FrameBufferFormat,
    samples: u32,
    features: TextureFormatFeatures,
) -> Result<bool, FallbackReason> {
    let flags = features.flags;
    let usages = features.allowed_usages;
    if !usages.contains(TextureUsages::RENDER_ATTACHMENT) {
        Err(FallbackReason::NotRenderable(format))
    } else if !flags.contains(TextureFormatFeatureFlags::BLENDABLE) {
        Err(FallbackReason::NotBlendable(format))
    } else if samples > 1 && !flags.sample_count_supported(samples) {
        Err(FallbackReason::SampleCount { format, samples })
    } else {
        Ok(flags.contains(TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE))
    }
}

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

/// Bevy's default handler ends the app on an error of the renderer. Where a frame that has another format is refused, and
/// the error is about that format, the cameras that had it are drawn in Bevy's from the next frame on. All other errors go
/// to the handler that the app has, and so does a second one, since no camera has the format then.
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
        let name = camera_name(camera, main_world.get(camera));
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
    use bevy::render::render_resource::WgpuFeatures;

    use super::*;
    use crate::settings::PackedFormat;

    #[test]
    fn what_every_adapter_can_do() {
        use FallbackReason::{NotBlendable, NotRenderable, SampleCount};
        let no_features = WgpuFeatures::empty();
        let [float16, unorm8, float32] = [
            PackedFormat::Float16,
            PackedFormat::Unorm8,
            PackedFormat::Float32,
        ]
        .map(FrameBufferFormat::from);
        let small_floats = FrameBufferFormat::Rg11b10Ufloat;
        let renderable = WgpuFeatures::RG11B10UFLOAT_RENDERABLE;
        let mut cases = vec![
            (float32, 1, no_features, Err(NotBlendable(float32))),
            (
                small_floats,
                1,
                no_features,
                Err(NotRenderable(small_floats)),
            ),
            (small_floats, 4, renderable, Ok(true)),
        ];
        for format in [float16, unorm8] {
            let too_few = |samples| Err(SampleCount { format, samples });
            cases.extend([
                (format, 1, no_features, Ok(true)),
                (format, 4, no_features, Ok(true)),
                (format, 2, no_features, too_few(2)),
                (format, 8, no_features, too_few(8)),
            ]);
        }
        for (format, samples, device_features, expected) in cases {
            let texture_format = format.texture_format();
            let features = texture_format.guaranteed_format_features(device_features);
            let actual = hardware_resolve(format, samples, features);
            assert_eq!(actual, expected, "{format:?} with {samples} samples");
        }
    }

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

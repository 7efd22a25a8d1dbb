//! What decides whether a camera can use a format: the camera itself, the app, systems of other plugins and the adapter.

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
    prelude::*,
    render::{
        Extract,
        camera::ExtractedCamera,
        render_resource::{
            TextureFormatFeatureFlags, TextureFormatFeatures, TextureUsages, WgpuFeatures,
        },
        renderer::{RenderAdapter, RenderDevice},
        sync_world::{MainEntity, RenderEntity},
        view::{ExtractedView, Msaa},
    },
};
use bevy_frugal_hooks::ShaderPatches;

use crate::{
    material::patches::REQUIRED,
    report::FallbackReason,
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

/// The adapter's support of multisampled textures of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FormatSupport {
    /// Whether the hardware can resolve samples of this format.
    pub hardware_resolve: bool,
}

impl FormatSupport {
    /// Queries the adapter.
    ///
    /// # Errors
    /// Returns the feature that the adapter lacks as the reason of the fallback.
    pub(crate) fn of(
        format: FrameBufferFormat,
        samples: u32,
        adapter: &RenderAdapter,
        device: &RenderDevice,
    ) -> Result<Self, FallbackReason> {
        let texture_format = format.texture_format();
        let specific = WgpuFeatures::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
        let features = if device.features().contains(specific) {
            adapter.get_texture_format_features(texture_format)
        } else {
            texture_format.guaranteed_format_features(device.features())
        };
        Self::from_features(format, samples, features)
    }

    fn from_features(
        format: FrameBufferFormat,
        samples: u32,
        features: TextureFormatFeatures,
    ) -> Result<Self, FallbackReason> {
        let flags = features.flags;
        if !features
            .allowed_usages
            .contains(TextureUsages::RENDER_ATTACHMENT)
        {
            return Err(FallbackReason::NotRenderable(format));
        }
        if !flags.contains(TextureFormatFeatureFlags::BLENDABLE) {
            return Err(FallbackReason::NotBlendable(format));
        }
        if samples > 1 && !flags.sample_count_supported(samples) {
            return Err(FallbackReason::SampleCount { format, samples });
        }
        Ok(Self {
            hardware_resolve: flags.contains(TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::PackedFormat;

    #[test]
    fn what_every_adapter_can_do() {
        let no_features = WgpuFeatures::empty();
        let resolved = Ok(FormatSupport {
            hardware_resolve: true,
        });
        let [float16, unorm8, float32] = [
            PackedFormat::Float16,
            PackedFormat::Unorm8,
            PackedFormat::Float32,
        ]
        .map(FrameBufferFormat::from);
        let small_floats = FrameBufferFormat::Rg11b10Ufloat;
        let renderable = WgpuFeatures::RG11B10UFLOAT_RENDERABLE;
        let mut cases = vec![
            (
                float32,
                1,
                no_features,
                Err(FallbackReason::NotBlendable(float32)),
            ),
            (
                small_floats,
                1,
                no_features,
                Err(FallbackReason::NotRenderable(small_floats)),
            ),
            (small_floats, 4, renderable, resolved.clone()),
        ];
        for format in [float16, unorm8] {
            let too_few = |samples| Err(FallbackReason::SampleCount { format, samples });
            cases.extend([
                (format, 1, no_features, resolved.clone()),
                (format, 4, no_features, resolved.clone()),
                (format, 2, no_features, too_few(2)),
                (format, 8, no_features, too_few(8)),
            ]);
        }
        for (format, samples, device_features, expected) in cases {
            let texture_format = format.texture_format();
            let features = texture_format.guaranteed_format_features(device_features);
            let actual = FormatSupport::from_features(format, samples, features);
            assert_eq!(actual, expected, "{format:?} with {samples} samples");
        }
    }
}

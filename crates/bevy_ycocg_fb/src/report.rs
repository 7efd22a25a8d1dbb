//! Reports on the state of each camera, the reasons for it, and the memory of its colour textures.

use std::{
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use bevy::{ecs::entity::EntityHashMap, platform::collections::HashSet, prelude::*};

use crate::settings::{
    DefaultFrameBufferQuality, FrameBufferFormat, FrameBufferQuality, PackedFormat,
};

/// What became of a camera's [`FrameBufferQuality`] in the last frame that was drawn. Component of every camera
/// with a quality, which the plugin adds and updates before `Update`.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct FrameBufferReport {
    /// How the camera is drawn.
    pub state: CameraState,
    /// The formats that were preferred to that of `state`, in the order of preference, and why they are not used.
    pub refused: Vec<RefusedFormat>,
    /// Memory of the camera's colour textures.
    pub memory: ColorMemory,
}

/// How a camera is drawn.
#[derive(Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum CameraState {
    /// No frame has been drawn yet, or Bevy's shaders are still loading.
    #[default]
    Pending,
    /// The camera has Bevy's format, as it should have, or draws no colours (`RenderTarget::None`).
    Exact,
    /// The camera draws packed colours in this format.
    Packed(PackedFormat),
    /// Bevy's passes draw the camera in [`FrameBufferFormat::Rg11b10Ufloat`].
    Rg11b10Ufloat,
    /// The camera has Bevy's format because it cannot use any of its quality, the last one for this reason.
    Fallback(FallbackReason),
}

/// A format that a camera cannot use.
#[derive(Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Debug, Clone, PartialEq)]
pub struct RefusedFormat {
    /// The format.
    pub format: FrameBufferFormat,
    /// Why the camera cannot use it.
    pub reason: FallbackReason,
}

/// Memory of the colour textures that a camera draws to, in bytes as allocated. Cameras with the same
/// target share the textures.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct ColorMemory {
    /// Bytes of the packed texture with one sample per pixel.
    pub packed: u64,
    /// Bytes of the multisampled packed texture; 0 where it stays in the tile memory of the GPU.
    pub packed_multisampled: u64,
    /// Bytes of Bevy's two main textures.
    pub main: u64,
    /// Bytes of Bevy's multisampled main texture.
    pub main_multisampled: u64,
}

impl ColorMemory {
    /// Returns the sum of all textures in bytes.
    pub fn total(self) -> u64 {
        self.packed + self.packed_multisampled + self.main + self.main_multisampled
    }
}

/// Message that the state of a camera's [`FrameBufferReport`] has changed.
#[derive(Message, Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Message, Debug, Clone, PartialEq)]
pub struct FrameBufferChanged {
    /// The camera.
    pub camera: Entity,
    /// Its new state.
    pub state: CameraState,
}

/// The reason for which a camera cannot use a format. Its text, by `Display`, names the remedy.
#[derive(Reflect, Clone, Debug, PartialEq, Eq, Hash)]
#[reflect(Debug, Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum FallbackReason {
    /// The camera has no 3D main pass.
    Not3d,
    /// A patch does not fit Bevy's shader; the text names the patch and the error.
    PatchRefused(String),
    /// A pipeline of this name, drawn by the camera, writes colours that are not packed.
    UnpackedPipeline(String),
    /// A pipeline of this name, drawn by the camera, blends or masks colours in a way that packed ones cannot.
    UnpackableBlending(String),
    /// A pipeline of this name, drawn by the camera, has a target of another format.
    FixedFormat(String),
    /// A pipeline of this name turns alpha into coverage, which WebGPU refuses in a format without alpha.
    AlphaToCoverage(String),
    /// A system of this name draws in Bevy's main pass, in which a packed camera has no target.
    MainPassSystem(String),
    /// The renderer refused a frame in this format; the text is its error.
    RefusedByRenderer(String),
    /// The camera uses deferred shading, whose lighting is not drawn by the packed main pass.
    DeferredPrepass,
    /// Screen-space reflections read the colour of the main pass.
    ScreenSpaceReflections,
    /// Order-independent transparency is resolved into Bevy's target.
    OrderIndependentTransparency,
    /// The atmosphere is drawn by a pipeline in Bevy's HDR format.
    Atmosphere,
    /// `CameraMainTextureUsages` asks for storage, whose shaders name Bevy's HDR format. Only for
    /// [`FrameBufferFormat::Rg11b10Ufloat`].
    StorageUsage,
    /// Wireframes are drawn into Bevy's target.
    Wireframes,
    /// The resolution of the main pass differs from that of its target.
    ResolutionOverride,
    /// The camera does not clear its target and draws over its content.
    NoClear,
    /// Bevy's MSAA writeback gives the camera the picture of an earlier one, in samples that it has not.
    MsaaWriteback,
    /// A later camera does not clear the target and needs the samples of this one.
    ContinuedByMultisampled,
    /// Another camera shares the picture and does not use this format, for the reason in the text, if it has any.
    /// Only for [`FrameBufferFormat::Rg11b10Ufloat`].
    ContinuedInAnotherFormat(String),
    /// A plugin draws over the picture of the camera in a format of its own, as `bevy_egui` does. Only for
    /// [`FrameBufferFormat::Rg11b10Ufloat`].
    DrawnOver,
    /// The clear colour is transparent, but the format has no alpha channel.
    TransparentBackground,
    /// The camera has `Hdr`, which 8 bits cannot store.
    Unorm8WithHdr,
    /// The adapter cannot render to this format.
    NotRenderable(FrameBufferFormat),
    /// The adapter cannot blend in this format.
    NotBlendable(FrameBufferFormat),
    /// The adapter does not support this number of samples in this format.
    SampleCount {
        /// Format of the texture.
        format: FrameBufferFormat,
        /// Number of samples per pixel.
        samples: u32,
    },
}

impl fmt::Display for FallbackReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Not3d => f.write_str("it is not a `Camera3d`: remove `FrameBufferQuality`"),
            Self::PatchRefused(what) => f.write_str(what),
            Self::UnpackedPipeline(name) => write!(
                f,
                "`{name}` writes unpacked colours: let its fragment shader end in Bevy's \
                 `main_pass_post_lighting_processing` or in `bevy_ycocg_fb::shaders::pack::pack_fragment`, \
                 and change no colour after it"
            ),
            Self::UnpackableBlending(name) => write!(
                f,
                "`{name}` blends or masks colour channels, which packed colours do not have: use \
                 `FrameBufferQuality::Compact`"
            ),
            Self::FixedFormat(name) => write!(
                f,
                "`{name}` is for targets of another format: give its pipeline the `target_format` of the view"
            ),
            Self::AlphaToCoverage(name) => write!(
                f,
                "`{name}` needs an alpha channel for `AlphaMode::AlphaToCoverage`: use `AlphaMode::Mask`"
            ),
            Self::MainPassSystem(name) => write!(
                f,
                "{name} draws in `Core3dSystems::MainPass`, which is replaced: use `FrameBufferQuality::Compact`, \
                 or draw in `Core3dSystems::EarlyPostProcess`"
            ),
            Self::RefusedByRenderer(error) => write!(
                f,
                "the renderer refused a frame in its format. Give pipelines the `target_format` of the view, or \
                 the camera `FrameBufferQuality::Exact`. {error}"
            ),
            Self::DeferredPrepass => f.write_str(
                "deferred shading does not go through its main pass: remove `DeferredPrepass`",
            ),
            Self::ScreenSpaceReflections => {
                f.write_str("`ScreenSpaceReflections` reads the main pass: remove it")
            }
            Self::OrderIndependentTransparency => f.write_str(
                "`OrderIndependentTransparencySettings` resolves into Bevy's target: remove it",
            ),
            Self::Atmosphere => {
                f.write_str("`Atmosphere` draws into Bevy's HDR target: use a skybox instead")
            }
            Self::StorageUsage => f.write_str(
                "`CameraMainTextureUsages` has `STORAGE_BINDING`, for shaders that write Bevy's HDR format: remove it",
            ),
            Self::Wireframes => f.write_str("wireframes draw into Bevy's target: hide them"),
            Self::ResolutionOverride => {
                f.write_str("`MainPassResolutionOverride` is not supported: remove it")
            }
            Self::NoClear => f.write_str(
                "`ClearColorConfig::None` draws over the content of the target: give it a clear colour",
            ),
            Self::MsaaWriteback => f.write_str(
                "`Camera::msaa_writeback` has it continue the picture of another camera in its samples: give \
                 both `FrameBufferQuality::Compact`, or `MsaaWriteback::Off`",
            ),
            Self::ContinuedByMultisampled => f.write_str(
                "a later camera of its target continues its multisampled picture: give both \
                 `FrameBufferQuality::Compact`, or `Msaa::Off`",
            ),
            Self::ContinuedInAnotherFormat(why) => write!(
                f,
                "a camera that shares its picture does not use this format: give both the same \
                 `FrameBufferQuality`. {why}"
            ),
            Self::DrawnOver => f.write_str(
                "a plugin draws over its picture in a format of its own: give that plugin a camera of its own",
            ),
            Self::TransparentBackground => f.write_str(
                "its format has no alpha: give the camera an opaque clear colour",
            ),
            Self::Unorm8WithHdr => {
                f.write_str("`PackedFormat::Unorm8` cannot store HDR: use `Float16` or remove `Hdr`")
            }
            Self::NotRenderable(format) => write!(
                f,
                "this adapter cannot render to {}: use `PackedFormat::Float16`",
                name(*format)
            ),
            Self::NotBlendable(format) => write!(
                f,
                "this adapter cannot blend in {}: use `PackedFormat::Float16`",
                name(*format)
            ),
            Self::SampleCount { format, samples } => write!(
                f,
                "this adapter does not support {samples} samples per pixel in {}: use `Msaa::Sample4` or \
                 `PackedFormat::Float16`",
                name(*format)
            ),
        }
    }
}

fn name(format: FrameBufferFormat) -> &'static str {
    match format {
        FrameBufferFormat::Packed(PackedFormat::Float16) => "`PackedFormat::Float16`",
        FrameBufferFormat::Packed(PackedFormat::Float32) => "`PackedFormat::Float32`",
        FrameBufferFormat::Packed(PackedFormat::Unorm8) => "`PackedFormat::Unorm8`",
        FrameBufferFormat::Rg11b10Ufloat => "`FrameBufferFormat::Rg11b10Ufloat`",
    }
}

/// The reports of the last frame, by camera in the main world. The render world replaces them as a whole, so that
/// the main world never sees those of half a frame.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct RenderedReports(Arc<Mutex<EntityHashMap<FrameBufferReport>>>);

impl RenderedReports {
    pub(crate) fn publish(&self, reports: EntityHashMap<FrameBufferReport>) {
        *self.lock() = reports;
    }

    fn lock(&self) -> MutexGuard<'_, EntityHashMap<FrameBufferReport>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Adds the components and the message.
pub(crate) struct ReportPlugin;

impl Plugin for ReportPlugin {
    fn build(&self, app: &mut App) {
        app.register_required_components::<FrameBufferQuality, FrameBufferReport>()
            .register_type::<FrameBufferReport>()
            .register_type::<FrameBufferChanged>()
            .add_message::<FrameBufferChanged>()
            .init_resource::<RenderedReports>()
            .add_systems(First, (require_reports, update_reports).chain());
    }
}

/// Gives a report to cameras that have the quality of the app, and takes it from those without any.
fn require_reports(
    mut commands: Commands,
    default: Option<Res<DefaultFrameBufferQuality>>,
    missing: Query<Entity, (With<Camera3d>, Without<FrameBufferReport>)>,
    unused: Query<Entity, (With<FrameBufferReport>, Without<FrameBufferQuality>)>,
) {
    if default.is_some() {
        for camera in &missing {
            commands.entity(camera).insert(FrameBufferReport::default());
        }
    } else {
        for camera in &unused {
            commands.entity(camera).remove::<FrameBufferReport>();
        }
    }
}

fn update_reports(
    mut cameras: Query<(Entity, Option<&Name>, &mut FrameBufferReport)>,
    rendered: Res<RenderedReports>,
    mut changes: MessageWriter<FrameBufferChanged>,
    mut logged: Local<HashSet<(Entity, FallbackReason)>>,
) {
    if cameras.is_empty() {
        return;
    }
    let rendered = rendered.lock();
    for (camera, name, mut report) in &mut cameras {
        let Some(new) = rendered.get(&camera).filter(|&new| *new != *report) else {
            continue;
        };
        if new.state != report.state {
            changes.write(FrameBufferChanged {
                camera,
                state: new.state.clone(),
            });
            if let CameraState::Fallback(reason) = &new.state
                && logged.insert((camera, reason.clone()))
            {
                let name = camera_name(camera, name);
                warn!("camera {name} does not use its FrameBufferQuality: {reason}");
            }
        }
        *report = new.clone();
    }
}

/// What messages call a camera.
pub(crate) fn camera_name(camera: Entity, name: Option<&Name>) -> String {
    name.map_or_else(|| camera.to_string(), |name| format!("`{name}`"))
}

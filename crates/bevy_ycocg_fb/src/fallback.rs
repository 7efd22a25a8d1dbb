//! The reasons for which a camera with a [`YCoCgFrameBuffer`](crate::YCoCgFrameBuffer) is drawn as without it.

use std::fmt;

use crate::settings::{FrameBufferFormat, PackedFormat};

/// The reason for which a camera is drawn as without its component. Its text, by `Display`, names the remedy.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum FallbackReason {
    /// The camera has no 3D main pass.
    Not3d,
    /// A patch does not fit Bevy's shader; the text names the patch and the error.
    PatchRefused(String),
    /// A pipeline of this name, drawn by the camera, writes colours that are not packed.
    UnpackedPipeline(String),
    /// The camera uses deferred shading, whose lighting is not drawn by the packed main pass.
    DeferredPrepass,
    /// Screen-space reflections read the colour of the main pass.
    ScreenSpaceReflections,
    /// Order-independent transparency is resolved into Bevy's target.
    OrderIndependentTransparency,
    /// The atmosphere is drawn into Bevy's target.
    Atmosphere,
    /// Wireframes are drawn into Bevy's target.
    Wireframes,
    /// The resolution of the main pass differs from that of its target.
    ResolutionOverride,
    /// The camera does not clear its target and draws over its content.
    NoClear,
    /// A later camera does not clear the target and needs the samples of this one.
    ContinuedByMultisampled,
    /// Another camera draws to the same target in another format, and one of the two continues the picture of
    /// the other. Only for [`FrameBufferFormat::Rg11b10Ufloat`].
    ContinuedInAnotherFormat,
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
            Self::Not3d => f.write_str("it is not a `Camera3d`: remove `YCoCgFrameBuffer`"),
            Self::PatchRefused(what) => write!(f, "{what}"),
            Self::UnpackedPipeline(name) => write!(
                f,
                "`{name}` writes unpacked colours: let its fragment shader end in Bevy's \
                 `main_pass_post_lighting_processing` or in `bevy_ycocg_fb::shaders::pack::pack_fragment`"
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
                f.write_str("`Atmosphere` draws into Bevy's target: use a skybox instead")
            }
            Self::Wireframes => f.write_str("wireframes draw into Bevy's target: hide them"),
            Self::ResolutionOverride => {
                f.write_str("`MainPassResolutionOverride` is not supported: remove it")
            }
            Self::NoClear => f.write_str(
                "`ClearColorConfig::None` draws over the content of the target: give it a clear colour",
            ),
            Self::ContinuedByMultisampled => f.write_str(
                "a later camera with `ClearColorConfig::None` continues its multisampled picture: \
                 give both `Msaa::Off`",
            ),
            Self::ContinuedInAnotherFormat => f.write_str(
                "a camera with `ClearColorConfig::None` and another format shares its target: give both the \
                 same format",
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

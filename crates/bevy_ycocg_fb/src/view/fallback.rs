//! Why a camera draws as Bevy does, its [`YCoCgFrameBuffer`](crate::YCoCgFrameBuffer)
//! notwithstanding.

use std::fmt;

use crate::settings::PackedFormat;

/// Why a camera is not packed; its text names the remedy.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum FallbackReason {
    /// It has no 3D main pass.
    Not3d,
    /// Bevy's shader is not as expected; the text says where.
    PatchRefused(String),
    /// A pipeline of this name, drawn by this camera, writes colours that are not packed.
    UnpackedPipeline(String),
    /// Deferred shading: what is shaded is not drawn by this pass.
    DeferredPrepass,
    /// It reads the colour of the main pass from within.
    ScreenSpaceReflections,
    /// It resolves transparency into Bevy's target.
    OrderIndependentTransparency,
    /// It draws the sky into Bevy's target.
    Atmosphere,
    /// Wireframes are drawn into Bevy's target.
    Wireframes,
    /// The main pass has another resolution than its target.
    ResolutionOverride,
    /// It draws over what is there.
    NoClear,
    /// A later camera draws over it and expects its samples.
    ContinuedByMultisampled,
    /// There is no alpha channel to keep a transparent background.
    TransparentBackground,
    /// 8 bits hold no HDR.
    Unorm8WithHdr,
    /// The adapter cannot render to this format.
    NotRenderable(PackedFormat),
    /// The adapter cannot blend in this format.
    NotBlendable(PackedFormat),
    /// The adapter has not so many samples in this format.
    SampleCount {
        /// The format.
        format: PackedFormat,
        /// Samples a pixel.
        samples: u32,
    },
}

impl fmt::Display for FallbackReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Not3d => f.write_str("it is no `Camera3d`"),
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
                "`ClearColorConfig::None` draws over what is there: give it a clear colour",
            ),
            Self::ContinuedByMultisampled => f.write_str(
                "a later camera with `ClearColorConfig::None` continues its multisampled picture: \
                 give both `Msaa::Off`",
            ),
            Self::TransparentBackground => f.write_str(
                "the packed target has no alpha: give the camera an opaque clear colour",
            ),
            Self::Unorm8WithHdr => {
                f.write_str("`PackedFormat::Unorm8` holds no HDR: use `Float16` or remove `Hdr`")
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
                "this adapter has no {samples} samples a pixel in {}: use `Msaa::Sample4` or \
                 `PackedFormat::Float16`",
                name(*format)
            ),
        }
    }
}

fn name(format: PackedFormat) -> &'static str {
    match format {
        PackedFormat::Float16 => "`PackedFormat::Float16`",
        PackedFormat::Float32 => "`PackedFormat::Float32`",
        PackedFormat::Unorm8 => "`PackedFormat::Unorm8`",
    }
}

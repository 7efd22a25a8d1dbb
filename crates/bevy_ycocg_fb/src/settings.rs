//! Settings of a camera's frame buffer.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

/// The dial from exact to small, by bytes of colour. Component of a camera.
///
/// Materials, lights and effects stay unchanged. A camera that cannot use a format is drawn as without the
/// component, and its [`FrameBufferReport`](crate::FrameBufferReport) has the reason. Cameras that draw on top of
/// the picture of this one, such as that of a view model, take its format with it unless they have a quality of
/// their own. [`DefaultFrameBufferQuality`] is for all cameras without the
/// component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Component, Reflect))]
#[cfg_attr(
    feature = "bevy",
    reflect(Component, Default, Debug, Clone, PartialEq, Hash)
)]
#[non_exhaustive]
pub enum FrameBufferQuality {
    /// Bevy's own target, 8 bytes per sample with `Hdr`.
    #[default]
    Exact,
    /// [`FrameBufferFormat::Rg11b10Ufloat`], 4 bytes per sample.
    Compact,
    /// [`PackedFormat::Unorm8`], 2 bytes per sample, for cameras without `Hdr`; else as `Compact`.
    Smallest,
    /// A packed format with its settings, and nothing else.
    Packed(YCoCgFrameBuffer),
}

impl FrameBufferQuality {
    /// Returns the formats in the order in which they are tried for a camera with or without `Hdr`; if none of them
    /// can be used, the camera has Bevy's.
    pub fn formats(self, hdr: bool) -> Vec<FrameBufferFormat> {
        use FrameBufferFormat::{Packed, Rg11b10Ufloat};
        match self {
            Self::Exact => vec![],
            Self::Compact => vec![Rg11b10Ufloat],
            // Without `Hdr`, Bevy's own format takes no more bytes than three small floats.
            Self::Smallest if !hdr => vec![Packed(PackedFormat::Unorm8)],
            Self::Smallest => vec![Packed(PackedFormat::Unorm8), Rg11b10Ufloat],
            Self::Packed(settings) => vec![Packed(settings.format)],
        }
    }

    /// Returns the settings with which the camera is packed, if it is.
    pub fn packed_settings(self) -> YCoCgFrameBuffer {
        match self {
            Self::Packed(settings) => settings,
            _ => YCoCgFrameBuffer::with_format(PackedFormat::Unorm8),
        }
    }
}

impl From<YCoCgFrameBuffer> for FrameBufferQuality {
    fn from(settings: YCoCgFrameBuffer) -> Self {
        Self::Packed(settings)
    }
}

/// The quality of all cameras in 3D that have no [`FrameBufferQuality`] of their own. Resource of an app.
#[cfg(feature = "bevy")]
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct DefaultFrameBufferQuality(pub FrameBufferQuality);

/// The settings of a packed frame buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
pub struct YCoCgFrameBuffer {
    /// The format of the colours. Default: [`PackedFormat::Float16`].
    pub format: PackedFormat,
    /// The filter that reconstructs the missing chrominance of packed colours. Default:
    /// [`Reconstruction::Wide`], which has the best quality on most measured scenes.
    pub reconstruction: Reconstruction,
    /// The weights by which the packed samples of a pixel are averaged. Default: [`MsaaResolve::Box`]. The colours
    /// of [`PackedFormat::Unorm8`] are tone-mapped already, so that both are the same there.
    pub msaa_resolve: MsaaResolve,
}

impl YCoCgFrameBuffer {
    /// Returns the default settings with another format.
    pub fn with_format(format: PackedFormat) -> Self {
        Self {
            format,
            ..Self::default()
        }
    }
}

/// The format of a camera's colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
#[non_exhaustive]
pub enum FrameBufferFormat {
    /// Luminance and one of two chrominances, which a pass of this crate resolves.
    Packed(PackedFormat),
    /// Three floats without sign, of 11, 11 and 10 bits, 4 bytes per sample, drawn by Bevy's own passes: HDR
    /// where the camera has `Hdr`. The mantissa has 6 bits, that of blue 5, so materials dither what they
    /// write. There is no alpha channel, and an adapter need not support it, although most do.
    Rg11b10Ufloat,
}

impl Default for FrameBufferFormat {
    fn default() -> Self {
        PackedFormat::default().into()
    }
}

impl From<PackedFormat> for FrameBufferFormat {
    fn from(format: PackedFormat) -> Self {
        Self::Packed(format)
    }
}

/// The storage format of packed pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
#[non_exhaustive]
pub enum PackedFormat {
    /// Two 16-bit floats, 4 bytes per sample: scene-linear HDR. Every adapter can render to it.
    #[default]
    Float16,
    /// Two 32-bit floats, 8 bytes per sample: scene-linear HDR where 11 bits of mantissa are too few.
    /// Not every adapter can blend in it.
    Float32,
    /// Two bytes per sample: tone-mapped and gamma-encoded, in codes that are finest in the dark and near gray,
    /// with a bias of 128/255 on the chrominance (thesis 4.7.2), only for cameras without `Hdr`. Samples are
    /// averaged in linear light, but blending works on codes: cameras with materials of `AlphaMode::Add` or
    /// `Premultiplied` use the next format, and multiplicative blending loses the bias. On photographs `EdgeDirected` is the better filter for it, on
    /// rendered scenes the default is.
    Unorm8,
}

/// The filter that reconstructs the missing chrominance of a pixel from its neighbours (thesis 4.5).
///
/// Pixels exchange what they have fetched within their quad of 2 x 2 fragments, by derivatives (thesis 4.5,
/// optimisations), so that they fetch fewer texels than a filter reads. On OpenGL and Metal, whose derivatives may be
/// coarse, they fetch all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
#[non_exhaustive]
pub enum Reconstruction {
    /// Takes the chrominance of the neighbour to the right, with 2 fetches per pixel.
    Nearest,
    /// Takes the mean of the four neighbours, with 3 fetches per pixel.
    Bilinear,
    /// Takes the mean of those of the four neighbours whose luminance differs by less than 30/255
    /// (thesis, listing 4.2), with 3 fetches per pixel. It is meant for values of 0 to 1.
    EdgeDirected,
    /// Interpolates chrominance relative to luminance, with larger weights for neighbours of similar
    /// luminance and for the axis along which chrominance changes less, and never gives a negative
    /// colour, with 3 fetches per pixel. The formula is at
    /// [`guided`](crate::reference::reconstruct::guided).
    Guided,
    /// Extends `Guided` by the other chrominance, which the four diagonal neighbours store, with 4
    /// fetches per pixel. It detects edges between colours of the same luminance. The formula is at
    /// [`wide`](crate::reference::reconstruct::wide).
    #[default]
    Wide,
    /// Interpolates as `Guided`, from the two neighbours in the same quad, with 1 fetch per pixel.
    Quad,
}

/// The weights by which the samples of a multisampled pixel are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(Reflect))]
#[cfg_attr(feature = "bevy", reflect(Default, Debug, Clone, PartialEq, Hash))]
#[non_exhaustive]
pub enum MsaaResolve {
    /// Equal weights, resolved by the hardware where it supports the format.
    #[default]
    Box,
    /// Weights of `1 / (1 + luminance)`, resolved in the shader, so that edges of very bright surfaces
    /// stay smooth after tone mapping.
    ToneMapWeighted,
}

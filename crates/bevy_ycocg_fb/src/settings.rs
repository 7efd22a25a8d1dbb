//! Settings of the packed frame buffer, per camera.

#[cfg(feature = "bevy")]
use bevy::{
    prelude::*,
    render::{RenderApp, extract_component::ExtractComponent},
};

/// Component of a camera that draws into two channels instead of four.
///
/// Materials, lights and effects stay unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(Component, Reflect, ExtractComponent),
    extract_app(RenderApp),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
pub struct YCoCgFrameBuffer {
    /// The format of the two channels. Default: [`PackedFormat::Float16`].
    pub format: PackedFormat,
    /// The filter that reconstructs the missing chrominance. Default: [`Reconstruction::Wide`], which
    /// has the best quality on most measured scenes.
    pub reconstruction: Reconstruction,
    /// The weights by which the samples of a multisampled pixel are averaged. Default:
    /// [`MsaaResolve::Box`].
    pub msaa_resolve: MsaaResolve,
}

/// The storage format of packed pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum PackedFormat {
    /// Two 16-bit floats, 4 bytes per sample: scene-linear HDR. Every adapter can render to it.
    #[default]
    Float16,
    /// Two 32-bit floats, 8 bytes per sample: scene-linear HDR where 11 bits of mantissa are too few.
    /// Not every adapter can blend in it.
    Float32,
    /// Two bytes per sample: tone-mapped and gamma-encoded, with a bias of 128/255 on the chrominance
    /// (thesis 4.7.2), only for cameras without `Hdr`. Blending and the averaging of samples work on
    /// gamma-encoded values, additive blending loses negative chrominance, and multiplicative blending
    /// loses the bias. On photographs `EdgeDirected` is the better filter for it, on rendered scenes the
    /// default is.
    Unorm8,
}

/// The filter that reconstructs the missing chrominance of a pixel from its neighbours (thesis 4.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum Reconstruction {
    /// Takes the chrominance of the neighbour to the right, with 2 fetches per pixel.
    Nearest,
    /// Takes the mean of the four neighbours, with 5 fetches per pixel.
    Bilinear,
    /// Takes the mean of those of the four neighbours whose luminance differs by less than 30/255
    /// (thesis, listing 4.2), with 5 fetches per pixel. It is meant for values of 0 to 1.
    EdgeDirected,
    /// Interpolates chrominance relative to luminance, with larger weights for neighbours of similar
    /// luminance and for the axis along which chrominance changes less, and never gives a negative
    /// colour, with 5 fetches per pixel. The formula is at
    /// [`guided`](crate::reference::reconstruct::guided).
    Guided,
    /// Extends `Guided` by the other chrominance, which the four diagonal neighbours store, with 9
    /// fetches per pixel. It detects edges between colours of the same luminance. The formula is at
    /// [`wide`](crate::reference::reconstruct::wide).
    #[default]
    Wide,
    /// Interpolates as `Guided`, from the two neighbours in the same quad of fragments (thesis 4.5,
    /// optimisations), with 1 fetch per pixel.
    Quad,
}

/// The weights by which the samples of a multisampled pixel are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum MsaaResolve {
    /// Equal weights, resolved by the hardware where it supports the format.
    #[default]
    Box,
    /// Weights of `1 / (1 + luminance)`, resolved in the shader, so that edges of very bright surfaces
    /// stay smooth after tone mapping.
    ToneMapWeighted,
}

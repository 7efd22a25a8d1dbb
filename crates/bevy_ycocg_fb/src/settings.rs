//! What a user chooses, per camera.

#[cfg(feature = "bevy")]
use bevy::{
    prelude::*,
    render::{RenderApp, extract_component::ExtractComponent},
};

/// Put this on a camera and it draws into two channels instead of four.
///
/// All its materials, lights and effects stay as they are.
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
    /// How the missing chrominance is found. Default: [`Reconstruction::Wide`],
    /// the best measured.
    pub reconstruction: Reconstruction,
    /// How the samples of a multisampled pixel become one. Default: [`MsaaResolve::Box`].
    pub msaa_resolve: MsaaResolve,
}

/// How a packed pixel is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum PackedFormat {
    /// Two 16-bit floats, 4 bytes a sample: scene-linear HDR. Every adapter renders to it.
    #[default]
    Float16,
    /// Two 32-bit floats, 8 bytes a sample: scene-linear HDR where 11 bits of mantissa are too few.
    Float32,
    /// Two bytes a sample: tone-mapped and gamma-encoded, chrominance with a bias of one half
    /// (thesis 4.7.2). Only for cameras without `Hdr`. Blending and the averaging of samples work
    /// on gamma-encoded values, additive blending loses negative chrominance and multiplicative
    /// blending the bias. On photographs `EdgeDirected` is the better filter for it, on rendered
    /// scenes the default is.
    Unorm8,
}

/// How the missing chrominance of a pixel is found from its neighbours (thesis 4.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum Reconstruction {
    /// That of the neighbour to the right: 2 fetches a pixel.
    Nearest,
    /// The mean of the four neighbours: 5 fetches.
    Bilinear,
    /// The mean of those of the four neighbours whose luminance differs by less than 30/255
    /// (thesis, listing 4.2): 5 fetches. Meant for values of 0 to 1.
    EdgeDirected,
    /// Chrominance relative to luminance, from the neighbours of similar luminance and the axis
    /// along which chrominance changes least, and never a negative colour: 5 fetches. The formula
    /// is at [`guided`](crate::reference::reconstruct::guided).
    Guided,
    /// As `Guided`, and it looks at the other chrominance too, which the four diagonal neighbours
    /// have: 9 fetches. Sees edges between colours of the same luminance. The formula is at
    /// [`wide`](crate::reference::reconstruct::wide).
    #[default]
    Wide,
    /// As `Guided`, from the two neighbours in the same quad of fragments (thesis 4.5,
    /// optimisations): 1 fetch.
    Quad,
}

/// How the samples of a multisampled pixel become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub enum MsaaResolve {
    /// Their mean, by the hardware where it can.
    #[default]
    Box,
    /// Their mean weighted by `1 / (1 + luminance)`, in the shader: edges of very bright surfaces
    /// stay smooth after tone mapping.
    ToneMapWeighted,
}

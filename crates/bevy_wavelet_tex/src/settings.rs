//! What an app chooses: how textures are sampled, and how they are loaded and saved.

use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

#[cfg(feature = "encode")]
pub use crate::asset::saver::{WaveletQuality, WaveletRole, WaveletSaverSettings};

/// Filters of decoded pixels, from the cheapest to the smoothest.
///
/// A decoded pixel with prediction takes four gathers and one load of luma (one load where the texture
/// was encoded with `Method::OneFetch` or in BC4), and one sample of chroma. Four neighbouring pixels
/// take four gathers and four loads together, and four samples of chroma.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[non_exhaustive]
pub enum WaveletFilter {
    /// The nearest pixel of the nearest mip: one decoded pixel.
    Nearest,
    /// The nearest pixels of two mips: two decoded pixels.
    NearestMipLinear,
    /// One decoded pixel, chosen at random with the weights of [`Self::Anisotropic`], anew in each
    /// frame. For cameras with temporal anti-aliasing, which averages the noise away; without it the
    /// picture is grainy.
    Stochastic,
    /// [`Self::Stochastic`] with the decoded pixels of 2 x 2 neighbouring pixels of the screen shared
    /// between them: about 7 dB less noise where the texture is magnified, and no less where it is
    /// minified.
    StochasticQuad,
    /// Bilinear between four pixels of the nearest mip.
    Bilinear,
    /// Trilinear between four pixels each of two mips.
    #[default]
    Trilinear,
    /// Up to 16 trilinear samples along the longer axis of a pixel's footprint, for surfaces at
    /// grazing angles. Costs as many trilinear samples as the footprint is longer than wide.
    Anisotropic,
}

impl WaveletFilter {
    pub(crate) const ALL: [Self; 7] = [
        Self::Nearest,
        Self::NearestMipLinear,
        Self::Stochastic,
        Self::StochasticQuad,
        Self::Bilinear,
        Self::Trilinear,
        Self::Anisotropic,
    ];
}

/// How coordinates outside of `[0, 1]` are addressed, as in wgpu's `AddressMode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum WaveletAddressMode {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The pixels of the edge repeat.
    ClampToEdge,
    /// The texture repeats, mirrored every other time.
    MirrorRepeat,
}

impl WaveletAddressMode {
    pub(crate) const ALL: [Self; 3] = [Self::Repeat, Self::ClampToEdge, Self::MirrorRepeat];
}

/// Representation of a texture on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum WaveletStorage {
    /// BC blocks, which the shader decodes. The adapter needs `TEXTURE_COMPRESSION_BC`.
    #[default]
    Blocks,
    /// RGBA8, decoded on the CPU. It looks the same and takes 6 to 16 times the memory.
    Decoded,
}

/// Settings of [`WaveletTextureLoader`](crate::asset::WaveletTextureLoader) for one texture, in its `.meta` file or from
/// `load_builder().with_settings`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaveletLoaderSettings {
    /// Whether to decode the texture to RGBA8 on load even where the adapter has BC. That takes 6
    /// to 16 times the memory and makes sampling cheaper. Default: `false`.
    pub decode_on_load: bool,
    /// Longest side in pixels: mip levels with longer sides are neither decompressed nor decoded nor uploaded. A
    /// texture without levels that are small enough has its last one. Default: `None`, no limit.
    ///
    /// For a setting that players change, read it in the closure of `with_settings`, which `AssetServer::reload`
    /// calls again.
    pub max_size: Option<u32>,
}

//! What an app chooses: how textures are sampled, and how they are loaded and saved.

#[cfg(feature = "encode")]
mod saver;

use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

#[cfg(feature = "encode")]
pub use saver::{WaveletQuality, WaveletRole, WaveletSaverSettings};

/// Filters of decoded pixels, from the cheapest to the smoothest.
///
/// A decoded pixel takes nine fetches of luma (one where the texture was encoded with
/// `Method::OneFetch` or in BC4) and one of chroma.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum WaveletFilter {
    /// The nearest pixel of the nearest mip: one decoded pixel.
    Nearest,
    /// The nearest pixels of two mips: two decoded pixels.
    NearestMipLinear,
    /// Bilinear between four pixels of the nearest mip.
    Bilinear,
    /// Trilinear between four pixels of one mip and the next mip, which is taken from the low band
    /// of the same texels (thesis section 3.5.3). Hand-made mips are ignored between levels, and
    /// sRGB is averaged before it is linearised.
    OneFetchTrilinear,
    /// Trilinear between four pixels each of two mips: eight decoded pixels.
    #[default]
    Trilinear,
    /// Trilinear where the texture is magnified. At grazing angles the texture unit filters the low
    /// band with up to 16 samples (thesis section 3.6.3). This needs textures whose sides are
    /// multiples of 8 times a power of two; others are filtered as with `Trilinear`.
    Anisotropic,
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WaveletStorage {
    /// BC blocks, which the shader decodes. The adapter needs `TEXTURE_COMPRESSION_BC`.
    #[default]
    Blocks,
    /// RGBA8, decoded on the CPU. It looks the same and takes 6 to 16 times the memory.
    Decoded,
}

/// Settings of [`WaveletTextureLoader`](crate::asset::WaveletTextureLoader) for one texture, in its `.meta` file or from
/// `load_with_settings`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WaveletLoaderSettings {
    /// Whether to decode the texture to RGBA8 on load even where the adapter has BC. That takes 6
    /// to 16 times the memory and makes sampling cheaper. Default: `false`.
    pub decode_on_load: bool,
}

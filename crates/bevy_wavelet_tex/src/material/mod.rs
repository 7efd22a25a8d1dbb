//! Wavelet textures on `StandardMaterial`: the extension, its uniforms and its shaders.
//!
//! | shader | contents |
//! | --- | --- |
//! | `types.wesl` | `bevy_wavelet_tex::material::types`: the parameters of a texture that a shader needs |
//! | `low_band.wesl` | `bevy_wavelet_tex::material::low_band`: reads the low band and predicts from it |
//! | `decode.wesl` | `bevy_wavelet_tex::material::decode`: decodes pixels |
//! | `sampling.wesl` | `bevy_wavelet_tex::material::sampling`: filters of decoded pixels |
//! | `stochastic.wesl` | `bevy_wavelet_tex::material::stochastic`: the filter that decodes one pixel |
//! | `bindings.wesl` | the bindings of the extension |
//! | `forward.wesl`, `prepass.wesl` | the fragment shaders of the extension |
//!
//! Any shader can import the first five.

mod bind_group;
mod extension;
mod uniform;

pub(crate) use bind_group::missing_textures;
pub use bind_group::{GpuWaveletTexture, WaveletSamplers, storage_on};
pub(crate) use extension::{Decals, Map, find_decals, rebind_materials, write_forms};
pub use extension::{WaveletExtension, WaveletForms, WaveletKey, WaveletStandardMaterial};

//! Wavelet textures on `StandardMaterial`: the extension, its uniforms and its shaders.
//!
//! | shader | contents |
//! | --- | --- |
//! | `types.wesl` | `bevy_wavelet_tex::material::types`: the parameters of a texture that a shader needs |
//! | `decode.wesl` | `bevy_wavelet_tex::material::decode`: decodes one pixel |
//! | `sampling.wesl` | `bevy_wavelet_tex::material::sampling`: filters of decoded pixels |
//! | `anisotropic.wesl` | `bevy_wavelet_tex::material::anisotropic`: the filter that uses the texture unit |
//! | `bindings.wesl` | the bindings of the extension |
//! | `forward.wesl`, `prepass.wesl` | the fragment shaders of the extension |
//!
//! Any shader can import the first four.

mod bind_group;
mod extension;
pub(crate) mod reload;
mod uniform;

pub use bind_group::{GpuWaveletTexture, WaveletSamplers};
pub use extension::{WaveletExtension, WaveletKey, WaveletStandardMaterial};

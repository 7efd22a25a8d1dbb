//! Wavelet textures on `StandardMaterial`: the extension, its uniforms and its shaders.
//!
//! | shader | what is in it |
//! | --- | --- |
//! | `types.wesl` | `bevy_wavelet_tex::material::types`: what a shader must know of a texture |
//! | `decode.wesl` | `bevy_wavelet_tex::material::decode`: one pixel |
//! | `sampling.wesl` | `bevy_wavelet_tex::material::sampling`: filters that decode first |
//! | `anisotropic.wesl` | `bevy_wavelet_tex::material::anisotropic`: the one that lets the texture unit filter |
//! | `bindings.wesl` | the textures of the extension |
//! | `forward.wesl`, `prepass.wesl` | its fragment shaders |
//!
//! The first four are libraries for any shader.

mod bind_group;
mod extension;
pub(crate) mod reload;
mod uniform;

pub use bind_group::{GpuWaveletTexture, WaveletSamplers};
pub use extension::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletKey, WaveletStandardMaterial,
};

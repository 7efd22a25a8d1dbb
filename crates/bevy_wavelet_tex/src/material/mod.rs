//! Wavelet textures on `StandardMaterial`: the extension, its uniforms and its shaders.
//!
//! | shader | what is in it |
//! | --- | --- |
//! | `types.wgsl` | `bevy_wavelet_tex::types`: what a shader must know of a texture |
//! | `decode.wgsl` | `bevy_wavelet_tex::decode`: one pixel |
//! | `sampling.wgsl` | `bevy_wavelet_tex::sampling`: filters that decode first |
//! | `anisotropic.wgsl` | `bevy_wavelet_tex::anisotropic`: the one that lets the texture unit filter |
//! | `bindings.wgsl` | the textures of the extension |
//! | `forward.wgsl`, `prepass.wgsl` | its fragment shaders |
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

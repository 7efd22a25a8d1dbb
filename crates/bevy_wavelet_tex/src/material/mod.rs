//! Wavelet textures on `StandardMaterial`: the extension, its uniforms and its shaders.
//!
//! `decode.wgsl` is a library for any shader (`#import bevy_wavelet_tex::decode`); `bindings.wgsl`
//! binds the textures of the extension, `forward.wgsl` is its fragment shader.

mod bind_group;
mod extension;
mod uniform;

pub use bind_group::GpuWaveletTexture;
pub use extension::{
    WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletKey, WaveletStandardMaterial,
};

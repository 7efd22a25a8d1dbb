//! Textures at 2 to 5 bits per pixel on any GPU that samples BC textures.
//!
//! The image is taken apart by a wavelet transform, the coefficients are stored in BC blocks, and
//! the shader puts them together again (P. Mavridis, *Efficient Texture
//! Representation and Sampling Algorithms for Real-time Rendering*, 2013, chapter 3).
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`codec`] | encoder and reference decoder, plain Rust |
//! | [`mod@file`] | the `.wtex` file |
//! | [`asset`] | the Bevy asset and its loader |
//! | [`gltf`] | wavelet textures in the place of those of a glTF file |
//! | [`material`] | the extension of `StandardMaterial` and its shaders |
//! | [`plugin`] | what an app adds |
//!
//! Without the feature `bevy` only the first two are compiled, without `encode` no encoder.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
#![cfg_attr(feature = "bevy", doc = include_str!("../README.md"))]

#[cfg(feature = "bevy")]
pub mod asset;
pub mod codec;
pub mod file;
#[cfg(feature = "bevy")]
pub mod gltf;
#[cfg(feature = "bevy")]
pub mod material;
#[cfg(feature = "bevy")]
pub mod plugin;

#[cfg(feature = "bevy")]
pub use asset::{WaveletLoaderSettings, WaveletStorage, WaveletTexture};
#[cfg(all(feature = "bevy", feature = "encode"))]
pub use asset::{
    WaveletProcessor, WaveletQuality, WaveletRole, WaveletSaver, WaveletSaverSettings,
};
#[cfg(feature = "bevy")]
pub use gltf::WaveletGltf;
#[cfg(feature = "bevy")]
pub use material::{WaveletAddressMode, WaveletExtension, WaveletFilter, WaveletStandardMaterial};
#[cfg(feature = "bevy")]
pub use plugin::WaveletTexPlugin;

//! Textures at 2 to 5 bits per pixel on any GPU that samples BC textures.
//!
//! A wavelet transform splits the image into coefficients, which are stored in BC blocks; the
//! shader reconstructs the pixels when it samples (P. Mavridis, *Efficient Texture Representation
//! and Sampling Algorithms for Real-time Rendering*, 2013, chapter 3).
//!
//! | module | contents |
//! | --- | --- |
//! | [`codec`] | the encoder and the reference decoder, in plain Rust |
//! | [`mod@file`] | the `.wtex` file format |
//! | [`asset`] | the Bevy asset, its loader and its saver |
//! | [`gltf`] | replaces the textures of a glTF file by wavelet textures |
//! | [`material`] | the extension of `StandardMaterial` and its shaders |
//! | [`plugin`] | the plugin that an app adds |
//! | [`settings`] | what an app chooses: filters, address modes, how textures are loaded and saved |
//!
//! Without the feature `bevy` only [`codec`] and [`mod@file`] are compiled; the encoder needs the
//! feature `encode`.
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
pub mod settings;

#[cfg(feature = "bevy")]
pub use asset::WaveletTexture;
#[cfg(all(feature = "bevy", feature = "encode"))]
pub use asset::{WaveletProcessor, WaveletSaver};
#[cfg(feature = "bevy")]
pub use gltf::WaveletGltf;
#[cfg(feature = "bevy")]
pub use material::{WaveletExtension, WaveletStandardMaterial};
#[cfg(feature = "bevy")]
pub use plugin::WaveletTexPlugin;
#[cfg(feature = "bevy")]
pub use settings::{WaveletAddressMode, WaveletFilter, WaveletLoaderSettings, WaveletStorage};
#[cfg(all(feature = "bevy", feature = "encode"))]
pub use settings::{WaveletQuality, WaveletRole, WaveletSaverSettings};

//! Textures at 2 to 5 bits per pixel on any GPU that samples BC textures.
//!
//! Without the feature `bevy` only [`codec`] and [`mod@file`] are compiled; the encoder needs the feature `encode`.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
// The first definition of a link counts: on docs.rs the README's lead to the repository.
#![cfg_attr(feature = "bevy", doc = concat!("[encoding]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/encoding.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[figures]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/wavelet_tex.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[migration]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/migration.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[picture]: ", env!("CARGO_PKG_REPOSITORY"), "/raw/main/docs/images/wavelet_tex.jpg"))]
#![cfg_attr(feature = "bevy", doc = concat!("[shaders]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/custom-shaders.md"))]
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

/// What most apps use: `use bevy_wavelet_tex::prelude::*`.
#[cfg(feature = "bevy")]
pub mod prelude {
    pub use crate::{
        WaveletExtension, WaveletFilter, WaveletGltf, WaveletLoaderSettings,
        WaveletStandardMaterial, WaveletTexPlugin, WaveletTexture,
    };
}

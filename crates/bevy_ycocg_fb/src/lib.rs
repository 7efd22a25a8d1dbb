//! An HDR frame buffer in half of the bytes or fewer.
//!
//! In a packed format the fragment shader packs every colour to its luminance and one of its two chrominances, which
//! alternate in a checkerboard; a filter reconstructs the missing chrominance afterwards (P. Mavridis,
//! *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013,
//! chapter 4). In `Rg11b10Ufloat` Bevy's own passes draw, with dither.
//!
//! | module | contents |
//! | --- | --- |
//! | [`settings`] | the settings of a camera |
//! | [`mod@reference`] | packing and reconstruction in plain Rust |
//! | `material` | packing in the shaders of materials |
//! | `view` | the choice of the cameras that use their format, and the preparation of their views |
//! | `pass` | the main pass of a packed camera, and the resolve |
//! | [`report`] | the state of each camera, the reasons for it, and its memory |
//! | [`plugin`] | the plugin that an app adds |
//!
//! Without the feature `bevy` only the first two are compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
#![cfg_attr(feature = "bevy", doc = include_str!("../README.md"))]

#[cfg(feature = "bevy")]
mod material;
#[cfg(feature = "bevy")]
mod pass;
#[cfg(feature = "bevy")]
pub mod plugin;
pub mod reference;
#[cfg(feature = "bevy")]
pub mod report;
pub mod settings;
#[cfg(feature = "bevy")]
mod view;

#[cfg(feature = "bevy")]
pub use plugin::YCoCgFrameBufferPlugin;
#[cfg(feature = "bevy")]
pub use report::{
    CameraState, ColorMemory, FallbackReason, FrameBufferChanged, FrameBufferReport, RefusedFormat,
};
#[cfg(feature = "bevy")]
pub use settings::DefaultFrameBufferQuality;
pub use settings::{
    FrameBufferFormat, FrameBufferQuality, MsaaResolve, PackedFormat, Reconstruction,
    YCoCgFrameBuffer,
};

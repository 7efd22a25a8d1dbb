//! An HDR frame buffer in two channels instead of four.
//!
//! The fragment shader packs every colour to its luminance and one of its two chrominances, which
//! alternate in a checkerboard; a filter reconstructs the missing chrominance afterwards (P. Mavridis,
//! *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013,
//! chapter 4).
//!
//! | module | contents |
//! | --- | --- |
//! | [`settings`] | the settings of a camera |
//! | [`mod@reference`] | packing and reconstruction in plain Rust |
//! | `packed_format` | the texture formats and shader defs of the packed formats |
//! | `material` | packing in the shaders of materials |
//! | `view` | the choice of the cameras that pack, and the preparation of their views |
//! | `pass` | the main pass of a packed camera, and the resolve |
//! | [`report`] | the state of each camera, and its memory |
//! | `fallback` | the reasons for which a camera does not pack |
//! | [`plugin`] | the plugin that an app adds |
//!
//! Without the feature `bevy` only the first two are compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
#![cfg_attr(feature = "bevy", doc = include_str!("../README.md"))]

#[cfg(feature = "bevy")]
mod fallback;
#[cfg(feature = "bevy")]
mod material;
#[cfg(feature = "bevy")]
mod packed_format;
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
pub use fallback::FallbackReason;
#[cfg(feature = "bevy")]
pub use plugin::YCoCgFrameBufferPlugin;
#[cfg(feature = "bevy")]
pub use report::{CameraReport, CameraState, ColorMemory, FrameBufferReports};
pub use settings::{MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer};

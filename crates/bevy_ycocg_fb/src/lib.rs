//! The HDR frame buffer in two channels instead of four.
//!
//! Every fragment is stored as its luminance and one of its two chrominances, in a checkerboard,
//! as it is shaded; a filter reconstructs the missing chrominance afterwards (P. Mavridis,
//! *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013,
//! chapter 4).
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`settings`] | what a user chooses |
//! | [`mod@reference`] | packing and reconstruction in plain Rust |
//! | `material` | how materials come to pack what they shade |
//! | `view` | which cameras pack, and how Bevy prepares for it |
//! | `pass` | the main pass of a packed camera, and the resolve |
//! | [`report`] | what became of each camera, and its memory |
//! | [`plugin`] | what an app adds |
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
pub use report::{CameraReport, CameraState, ColorMemory, FrameBufferReports};
pub use settings::{MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer};
#[cfg(feature = "bevy")]
pub use view::fallback::FallbackReason;

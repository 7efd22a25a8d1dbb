//! A frame buffer in half of the bytes or fewer.
//!
//! Without the feature `bevy` only [`settings`] and [`mod@reference`] are compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
// The first definition of a link counts: on docs.rs the README's lead to the repository.
#![cfg_attr(feature = "bevy", doc = concat!("[figures]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/ycocg_fb.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[migration]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/migration.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[picture]: ", env!("CARGO_PKG_REPOSITORY"), "/raw/main/docs/images/ycocg_fb.jpg"))]
#![cfg_attr(feature = "bevy", doc = concat!("[shaders]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/custom-shaders.md"))]
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

/// What most apps use: `use bevy_ycocg_fb::prelude::*`.
#[cfg(feature = "bevy")]
pub mod prelude {
    pub use crate::{
        CameraState, DefaultFrameBufferQuality, FrameBufferChanged, FrameBufferQuality,
        FrameBufferReport, YCoCgFrameBuffer, YCoCgFrameBufferPlugin,
    };
}

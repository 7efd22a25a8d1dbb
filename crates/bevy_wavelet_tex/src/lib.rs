//! Wavelet textures for Bevy.
#![warn(missing_docs)]

pub mod codec;
pub mod file;

//! Packing and reconstruction in plain Rust, as the reference for the shaders' tests.
//!
//! | module | contents |
//! | --- | --- |
//! | [`color`] | conversion of RGB to YCoCg and back |
//! | [`mod@pack`] | packing of a fragment's colour |
//! | [`storage`] | rounding of a packed pixel by its storage format |
//! | [`image`] | a packed viewport, with mirrored neighbours beyond its border |
//! | [`mod@reconstruct`] | reconstruction of a colour from a packed pixel and its neighbours |
//! | [`msaa`] | resolve of the samples of a pixel |

pub mod color;
pub mod image;
pub mod msaa;
pub mod pack;
pub mod reconstruct;
pub mod storage;

pub use color::YCoCg;
pub use image::PackedImage;
pub use pack::{PackedPixel, pack};
pub use reconstruct::{decode, reconstruct};

#[cfg(test)]
mod tests;

//! Packing, reconstruction and rounding in plain Rust, as the reference for the shaders' tests.
//!
//! | module | contents |
//! | --- | --- |
//! | [`color`] | conversion of RGB to YCoCg and back |
//! | [`mod@pack`] | packing of a fragment's colour |
//! | [`dither`] | the threshold of an ordered dither |
//! | [`rg11b10ufloat`] | rounding, with dither, to three small floats |
//! | [`unorm8`] | packing for the 8-bit format, and its codes |
//! | [`storage`] | rounding of a packed pixel by its storage format |
//! | [`image`] | a packed viewport, with mirrored neighbours beyond its border |
//! | [`mod@reconstruct`] | reconstruction of a colour from a packed pixel and its neighbours |
//! | [`msaa`] | resolve of the samples of a pixel |

pub mod color;
pub mod dither;
pub mod image;
pub mod msaa;
pub mod pack;
pub mod reconstruct;
pub mod rg11b10ufloat;
pub mod storage;
pub mod unorm8;

pub use color::YCoCg;
pub use image::PackedImage;
pub use pack::{PackedPixel, pack};
pub use reconstruct::{decode, reconstruct};

#[cfg(test)]
mod tests;

//! Packing, reconstruction and rounding in plain Rust, as the reference for the shaders' tests.
//!
//! | module | contents |
//! | --- | --- |
//! | [`color`] | conversion of RGB to YCoCg and back |
//! | [`mod@pack`] | packing of a fragment's colour |
//! | [`rg11b10ufloat`] | rounding, with dither, to three small floats |
//! | [`storage`] | rounding of a packed pixel by its storage format, and the codes of the 8-bit one |
//! | [`image`] | a packed viewport, with mirrored neighbours beyond its border |
//! | [`mod@reconstruct`] | reconstruction of a colour from a packed pixel and its neighbours, and resolve of samples |

pub mod color;
pub mod image;
pub mod pack;
pub mod reconstruct;
pub mod rg11b10ufloat;
pub mod storage;

pub use color::YCoCg;
pub use image::PackedImage;
pub use pack::{PackedPixel, pack};
pub use reconstruct::{decode, reconstruct};
pub use storage::unorm8;

#[cfg(test)]
mod tests;

//! Packing and reconstruction in plain Rust: what the shaders are tested against.
//!
//! | module | gives |
//! | --- | --- |
//! | [`color`] | RGB to YCoCg and back |
//! | [`mod@pack`] | a fragment's colour to a packed pixel |
//! | [`storage`] | what a format makes of a packed pixel |
//! | [`image`] | a packed viewport, and its neighbours beyond the border |
//! | [`mod@reconstruct`] | a packed pixel and its neighbours to a colour |
//! | [`msaa`] | the samples of a pixel to one |

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

//! Packing, reconstruction and rounding in plain Rust, as the reference for the shaders' tests.
//!
//! | module | contents |
//! | --- | --- |
//! | [`mod@pack`] | packing of a fragment's colour, its rounding by the storage format, and a packed viewport |
//! | [`rg11b10ufloat`] | rounding, with dither, to three small floats |
//! | [`mod@reconstruct`] | reconstruction of a colour from a packed pixel and its neighbours, and resolve of samples |

pub mod pack;
pub mod reconstruct;
pub mod rg11b10ufloat;

pub use pack::{PackedImage, PackedPixel, YCoCg, pack, unorm8};
pub use reconstruct::{decode, reconstruct};

#[cfg(test)]
mod tests;

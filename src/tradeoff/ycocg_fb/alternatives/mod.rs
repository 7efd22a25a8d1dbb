//! Other ways to save the same memory (thesis 4.6).
//!
//! As in the thesis, all store what a display shows: tone-mapped, sRGB-encoded
//! and in 2 bytes a pixel, one for the Bayer mosaic. Their pictures go in and come out as encoded
//! values of 0 to 1; what goes in has not been rounded to 8 bits.
//!
//! | module | stores |
//! | --- | --- |
//! | [`fewer_pixels`] | 8-bit RGB, a third fewer pixels |
//! | [`rgb565`] | all pixels, 5, 6 and 5 bits with dither |
//! | [`y8co4cg4`] | all pixels, 8, 4 and 4 bits with dither |
//! | [`bayer`] | red, green or blue |
//! | [`rgb_checkerboard`] | green, and red or blue |

pub mod bayer;
mod dither;
pub mod fewer_pixels;
pub mod rgb565;
pub mod rgb_checkerboard;
pub mod y8co4cg4;

#[cfg(test)]
mod tests;

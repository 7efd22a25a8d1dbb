//! Textures without a wavelet: the pixels themselves in BC1, BC4, BC5 or BC7, at full size or
//! smaller, which the texture unit filters by itself. At full size, an image whose sides are no whole blocks
//! is padded with its outermost pixels; the texture unit cannot filter across its edges, so the shader
//! filters it as it does wavelets. Resampled to the next smaller size in whole blocks, game textures lose 0.6
//! to 4 dB in BC1 and 4 to 20 in BC7.
//!
//! They are what a game has today, and better than a wavelet where an image has hardly anything that
//! a wavelet predicts: saturated edges, text, channels that have nothing in common. The encoder
//! measures them beside the wavelet and keeps what has the least error, so that no image
//! at any rate is worse than they are. A smaller texture has the texels whose interpolation comes
//! closest to the image, which is better than a smaller image that a bicubic filter magnifies.
//!
//! A smaller texture is interpolated as it is stored and linearised after that, which comes 0.2 to 1.5
//! dB closer to game textures than interpolation in linear light. At full size, where a pixel is a
//! texel, the texture unit filters colour in linear light, as it does all sRGB textures; gray it does
//! not, since BC4 has no sRGB variant. The shader filters what is padded in linear light.

#[cfg(feature = "encode")]
mod choose;
#[cfg(feature = "encode")]
mod color_blocks;
#[cfg(feature = "encode")]
mod encode;
#[cfg(feature = "encode")]
mod estimate;
mod texture;

#[cfg(feature = "encode")]
pub(super) use choose::better;
#[cfg(feature = "encode")]
pub(super) use encode::{Channels, add_level};
pub(super) use texture::PlainRows;
pub use texture::PlainTexture;

//! Wavelet textures as Bevy assets.

mod loader;
#[cfg(feature = "encode")]
pub(crate) mod saver;
mod texture;

pub use loader::{
    BlockLack, DECODE_BUDGET, DECODE_BYTES_PER_PIXEL, WaveletLoadError, WaveletTextureLoader,
};
#[cfg(feature = "encode")]
pub use saver::{WaveletProcessor, WaveletSaveError, WaveletSaver};
pub(crate) use texture::MipAtlas;
pub use texture::{Parts, PlainParameters, TextureGroup, TextureParameters, WaveletTexture};

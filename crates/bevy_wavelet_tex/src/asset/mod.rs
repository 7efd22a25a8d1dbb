//! Wavelet textures as Bevy assets.

mod atlas;
mod loader;
#[cfg(feature = "encode")]
mod saver;
mod texture;

pub(crate) use atlas::MipAtlas;
pub use loader::{
    BlockLack, DECODE_BUDGET, DECODE_BYTES_PER_PIXEL, WaveletLoadError, WaveletTextureLoader,
};
#[cfg(feature = "encode")]
pub use saver::{WaveletProcessor, WaveletSaveError, WaveletSaver};
pub(crate) use texture::Part;
pub use texture::{Parts, PlainParameters, TextureGroup, TextureParameters, WaveletTexture};

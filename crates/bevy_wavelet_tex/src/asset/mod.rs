//! Wavelet textures as Bevy assets.

mod loader;
#[cfg(feature = "encode")]
mod saver;
mod texture;

pub use loader::{WaveletLoadError, WaveletLoaderSettings, WaveletTextureLoader};
#[cfg(feature = "encode")]
pub use saver::{
    WaveletProcessor, WaveletQuality, WaveletRole, WaveletSaveError, WaveletSaver,
    WaveletSaverSettings,
};
pub(crate) use texture::Part;
pub use texture::{Parts, TextureGroup, WaveletStorage, WaveletTexture};

//! Wavelet textures as Bevy assets.

mod atlas;
mod loader;
#[cfg(feature = "encode")]
mod saver;
#[cfg(feature = "encode")]
mod texels;
mod texture;

pub(crate) use atlas::MipAtlas;
pub use loader::{BlockLack, WaveletLoadError, WaveletTextureLoader};
#[cfg(feature = "encode")]
pub use saver::{WaveletProcessor, WaveletSaveError, WaveletSaver};
pub(crate) use texture::Part;
pub use texture::{Parts, PlainParameters, TextureGroup, WaveletTexture};

//! Wavelet textures as Bevy assets.

mod loader;
mod texture;

pub use loader::{WaveletLoadError, WaveletLoaderSettings, WaveletTextureLoader};
pub use texture::{WaveletStorage, WaveletTexture};

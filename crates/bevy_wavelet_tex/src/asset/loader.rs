//! The loader of `.wtex` files.

use std::sync::Once;

use bevy::{
    asset::{AssetLoader, LoadContext, io::Reader},
    log::warn,
    reflect::TypePath,
};
use thiserror::Error;

use super::texture::WaveletTexture;
use crate::{
    file::{self, ReadError},
    settings::{WaveletLoaderSettings, WaveletStorage},
};

/// Loads [`WaveletTexture`]s. Their images have the labels `luma`, `detail`, `chroma` or `decoded`.
#[derive(TypePath)]
pub struct WaveletTextureLoader {
    /// Whether the adapter samples BC textures.
    supports_bc: bool,
}

/// The reason why a texture was not loaded.
#[derive(Debug, Error)]
pub enum WaveletLoadError {
    /// The file could not be read.
    #[error("cannot read wavelet texture '{path}': {source}")]
    Io {
        /// Asset path of the file.
        path: String,
        /// Error of the asset source.
        source: std::io::Error,
    },
    /// The file is not a valid wavelet texture.
    #[error("cannot load wavelet texture '{path}': {source}")]
    Read {
        /// Asset path of the file.
        path: String,
        /// The reason why the file is not valid.
        source: ReadError,
    },
}

impl WaveletTextureLoader {
    /// Makes a loader. `supports_bc` is whether the adapter samples BC textures; without them
    /// textures are decoded to RGBA8 on load.
    pub fn new(supports_bc: bool) -> Self {
        Self { supports_bc }
    }

    fn storage(&self, settings: &WaveletLoaderSettings) -> WaveletStorage {
        static WARNED: Once = Once::new();
        if !self.supports_bc {
            WARNED.call_once(|| {
                warn!(
                    "the adapter lacks TEXTURE_COMPRESSION_BC: wavelet textures are decoded on \
                     load to RGBA8 and take 6 to 16 times the memory"
                );
            });
        }
        if self.supports_bc && !settings.decode_on_load {
            WaveletStorage::Blocks
        } else {
            WaveletStorage::Decoded
        }
    }
}

impl AssetLoader for WaveletTextureLoader {
    type Asset = WaveletTexture;
    type Settings = WaveletLoaderSettings;
    type Error = WaveletLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &WaveletLoaderSettings,
        load_context: &mut LoadContext<'_>,
    ) -> Result<WaveletTexture, WaveletLoadError> {
        let path = load_context.path().to_string();
        let mut bytes = Vec::new();
        if let Err(source) = reader.read_to_end(&mut bytes).await {
            return Err(WaveletLoadError::Io { path, source });
        }
        let image = file::read(&bytes).map_err(|source| WaveletLoadError::Read { path, source })?;
        let storage = self.storage(settings);
        Ok(WaveletTexture::new(&image, storage, |label, image| {
            load_context.add_labeled_asset(label.to_string(), image)
        }))
    }

    fn extensions(&self) -> &[&str] {
        &[file::EXTENSION]
    }
}

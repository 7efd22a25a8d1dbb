//! Encoding of images when assets are processed.

use bevy::{
    asset::{
        AssetPath, AsyncWriteExt,
        io::Writer,
        processor::LoadTransformAndSave,
        saver::{AssetSaver, SavedAsset},
        transformer::IdentityAssetTransformer,
    },
    image::{Image, ImageLoader},
    reflect::TypePath,
    render::render_resource::TextureFormat,
};
use thiserror::Error;

use super::loader::WaveletTextureLoader;
use crate::{
    codec::{
        angle::normal_blue,
        encoder::{EncodeError, encode},
        image::Content,
        layout,
        rate::Rate,
        reduce::reduced_rgba8,
        settings::{EncodeSettings, Method},
        source::{Pixels, Source},
    },
    file,
    settings::{WaveletLoaderSettings, WaveletRole, WaveletSaverSettings},
};

/// Converts images to wavelet textures under `AssetMode::Processed`, where a `.meta` file names it.
///
/// [`WaveletTexPlugin`](crate::WaveletTexPlugin) registers it, but not as the default of any file
/// extension.
pub type WaveletProcessor =
    LoadTransformAndSave<ImageLoader, IdentityAssetTransformer<Image>, WaveletSaver>;

/// Saves an image as a wavelet texture.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct WaveletSaver;

/// The reason why an image was not saved.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WaveletSaveError {
    /// The pixels are in a format that the encoder does not read.
    #[error("cannot encode '{path}': its format {format:?} is neither 8 nor 16 bits a channel")]
    Format {
        /// The image's asset path.
        path: String,
        /// Texture format of the image.
        format: TextureFormat,
    },
    /// The image is a texture that is compressed already, such as a KTX2 file in a BC format.
    #[error(
        "cannot encode '{path}': its format {format:?} is block-compressed: encode the original image instead"
    )]
    Blocks {
        /// The image's asset path.
        path: String,
        /// Texture format of the image.
        format: TextureFormat,
    },
    /// The settings ask for Zstandard, which this build lacks.
    #[error(
        "cannot encode '{path}' with Zstandard: enable the feature `zstd_encode` of bevy_wavelet_tex, or leave \
         the setting `zstd` away"
    )]
    ZstdDisabled {
        /// The image's asset path.
        path: String,
    },
    /// The image is not two-dimensional, or its pixels are not in main memory.
    #[error(
        "cannot encode '{path}': it is an array, a cube or a volume, or its pixels are not in main memory"
    )]
    Shape {
        /// The image's asset path.
        path: String,
    },
    /// The rate does not belong to the role.
    #[error("cannot encode '{path}': {} is not a rate of the role {role:?}; possible are {}", .rate.name(), possible(*role))]
    Rate {
        /// The image's asset path.
        path: String,
        /// The requested rate.
        rate: Rate,
        /// The requested role.
        role: WaveletRole,
    },
    /// The encoder returned an error.
    #[error("cannot encode '{path}': {source}")]
    Encode {
        /// The image's asset path.
        path: String,
        /// Error of the encoder.
        source: EncodeError,
    },
    /// The texture could not be written.
    #[error("cannot write the wavelet texture of '{path}': {source}")]
    Io {
        /// The image's asset path.
        path: String,
        /// Error of the asset writer.
        source: std::io::Error,
    },
}

fn possible(role: WaveletRole) -> String {
    let names: Vec<_> = Rate::of(role.content()).map(Rate::name).collect();
    names.join(", ")
}

impl WaveletSaverSettings {
    /// Encodes an image and returns the bytes of its `.wtex` file.
    ///
    /// # Errors
    /// Returns a [`WaveletSaveError`], whose message names the image as `path`.
    pub fn encode(&self, image: &Image, path: &str) -> Result<Vec<u8>, WaveletSaveError> {
        let path = || path.to_string();
        let content = self.role.content();
        let (rate, min_psnr_db) = self.quality.goal(content);
        if rate.content(false) != content {
            return Err(WaveletSaveError::Rate {
                path: path(),
                rate,
                role: self.role,
            });
        }
        let texels =
            texels(image, content).ok_or_else(|| WaveletSaveError::Shape { path: path() })?;
        let texels = texels.map_err(|format| {
            let path = path();
            match format.is_compressed() {
                true => WaveletSaveError::Blocks { path, format },
                false => WaveletSaveError::Format { path, format },
            }
        })?;
        let color_space = self.role.color_space();
        let size = [image.width(), image.height()];
        let reduced;
        let source = match self.max_size {
            Some(most) if size.iter().any(|s| *s > most.max(1)) => {
                let pixels = |i: usize| texels.first().get(i);
                reduced = reduced_rgba8(size, pixels, most.max(1), color_space);
                Source::new(reduced.0, Pixels::Rgba8(&reduced.1))
            }
            _ => texels.source(size),
        };
        let settings = EncodeSettings {
            rate,
            min_psnr_db,
            alpha: self.alpha,
            gray: self.role.gray(),
            alpha_cutoff: self.alpha_cutoff.or(self.role.usual_cutoff()),
            color_space,
            mips: self.mips,
            effort: self.effort,
            method: if self.one_fetch {
                Method::OneFetch
            } else {
                Method::Best
            },
            formats: self.formats,
        };
        let encoded = encode(&source, &settings, &|_, _| {});
        let encoded = encoded.map_err(|source| WaveletSaveError::Encode {
            path: path(),
            source,
        })?;
        match self.zstd {
            None => Ok(file::write(&encoded)),
            #[cfg(feature = "zstd_encode")]
            Some(level) => Ok(file::write_zstd(&encoded, level)),
            #[cfg(not(feature = "zstd_encode"))]
            Some(_) => Err(WaveletSaveError::ZstdDisabled { path: path() }),
        }
    }
}

impl AssetSaver for WaveletSaver {
    type Asset = Image;
    type Settings = WaveletSaverSettings;
    type OutputLoader = WaveletTextureLoader;
    type Error = WaveletSaveError;

    async fn save(
        &self,
        writer: &mut Writer,
        asset: SavedAsset<'_, '_, Image>,
        settings: &WaveletSaverSettings,
        asset_path: AssetPath<'_>,
    ) -> Result<WaveletLoaderSettings, WaveletSaveError> {
        let path = asset_path.to_string();
        let bytes = settings.encode(asset.get(), &path)?;
        match writer.write_all(&bytes).await {
            Ok(()) => Ok(WaveletLoaderSettings::default()),
            Err(source) => Err(WaveletSaveError::Io { path, source }),
        }
    }
}

/// The texels of an image, all levels one after the other.
enum Texels<'a> {
    Gray8(&'a [u8]),
    Rgba8(&'a [[u8; 4]]),
    Rgb8(Vec<[u8; 3]>),
    Gray16(Vec<u16>),
    Rgba16(Vec<[u16; 4]>),
}

impl Texels<'_> {
    fn first(&self) -> Pixels<'_> {
        self.range(0, usize::MAX)
    }

    fn range(&self, start: usize, length: usize) -> Pixels<'_> {
        fn part<T>(all: &[T], start: usize, length: usize) -> &[T] {
            let end = start.saturating_add(length).min(all.len());
            &all[start.min(end)..end]
        }
        match self {
            Self::Gray8(texels) => Pixels::Gray8(part(texels, start, length)),
            Self::Rgba8(texels) => Pixels::Rgba8(part(texels, start, length)),
            Self::Rgb8(texels) => Pixels::Rgb8(part(texels, start, length)),
            Self::Gray16(texels) => Pixels::Gray16(part(texels, start, length)),
            Self::Rgba16(texels) => Pixels::Rgba16(part(texels, start, length)),
        }
    }

    /// Splits the texels into the levels that the image has.
    fn source(&self, size: [u32; 2]) -> Source<'_> {
        let all = self.first().len();
        let mut levels = Vec::new();
        let mut start = 0;
        while start < all {
            let [width, height] = layout::mip_size(size, levels.len() as u32);
            let length = width as usize * height as usize;
            levels.push(self.range(start, length));
            start += length;
        }
        Source { size, levels }
    }
}

/// The texels of an image: `None` where it is not two-dimensional or has no pixels in main memory,
/// and its format as an error where that is not supported.
fn texels(image: &Image, content: Content) -> Option<Result<Texels<'_>, TextureFormat>> {
    let data = image.data.as_deref()?;
    if image.texture_descriptor.size.depth_or_array_layers != 1 {
        return None;
    }
    let words = || {
        let (pairs, _) = data.as_chunks::<2>();
        pairs.iter().map(|pair| u16::from_le_bytes(*pair))
    };
    Some(Ok(match image.texture_descriptor.format {
        TextureFormat::R8Unorm => Texels::Gray8(data),
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => {
            Texels::Rgba8(data.as_chunks::<4>().0)
        }
        TextureFormat::Rg8Unorm => {
            let (pairs, _) = data.as_chunks::<2>();
            Texels::Rgb8(pairs.iter().map(|pair| with_blue(*pair, content)).collect())
        }
        TextureFormat::R16Unorm => Texels::Gray16(words().collect()),
        TextureFormat::Rgba16Unorm => {
            let words: Vec<u16> = words().collect();
            Texels::Rgba16(words.as_chunks::<4>().0.to_vec())
        }
        other => return Some(Err(other)),
    }))
}

/// Adds the blue of two channels: of normals the Z of a unit vector, of others 0.
fn with_blue([r, g]: [u8; 2], content: Content) -> [u8; 3] {
    match content {
        Content::Normal => [r, g, normal_blue([r, g])],
        _ => [r, g, 0],
    }
}

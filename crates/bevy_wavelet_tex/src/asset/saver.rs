//! Encoding images when assets are processed.

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
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{WaveletLoaderSettings, WaveletTextureLoader};
use crate::{
    codec::{
        encoder::{EncodeError, EncodeSettings, Method, encode},
        image::{ColorSpace, Content},
        layout,
        rate::Rate,
        reduce::reduced_rgba8,
        search::Effort,
        source::{Pixels, Source},
    },
    file,
};

/// Makes wavelet textures of images under `AssetMode::Processed`, where a `.meta` file names it.
///
/// It is registered by [`WaveletTexPlugin`](crate::WaveletTexPlugin) but takes over no extension.
pub type WaveletProcessor =
    LoadTransformAndSave<ImageLoader, IdentityAssetTransformer<Image>, WaveletSaver>;

/// Saves an image as a wavelet texture.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct WaveletSaver;

/// How [`WaveletSaver`] encodes; in a `.meta` file the `saver_settings`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaveletSaverSettings {
    /// What the image holds. Default: colour.
    pub role: WaveletRole,
    /// How good it has to be. Default: [`WaveletQuality::Usual`].
    pub quality: WaveletQuality,
    /// Whether colour keeps its alpha channel. Default: no.
    pub alpha: bool,
    /// How hard to search. Default: [`Effort::Default`].
    pub effort: Effort,
    /// Whether to make mips where the image has none. Default: yes.
    pub mips: bool,
    /// The image is halved until no side is longer, in pixels. Default: no limit.
    pub max_size: Option<u32>,
    /// Encode without prediction, for cheaper sampling. Default: no.
    pub one_fetch: bool,
}

impl Default for WaveletSaverSettings {
    fn default() -> Self {
        Self {
            role: WaveletRole::default(),
            quality: WaveletQuality::default(),
            alpha: false,
            effort: Effort::default(),
            mips: true,
            max_size: None,
            one_fetch: false,
        }
    }
}

/// How good a texture has to be, by its size or by its error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum WaveletQuality {
    /// The usual rate of the role: 2 bits per pixel for gray, 3 for colour, 4 for normals.
    #[default]
    Usual,
    /// This rate, which must be one of the role's.
    Rate(Rate),
    /// The smallest rate of the role that comes to at least this PSNR in dB, measured on the image
    /// itself, as encoded; the largest where none does. The README has what the rates come to on
    /// photographs.
    MinPsnr(f64),
}

impl WaveletQuality {
    /// The rate to encode with, and the PSNR in dB for whose sake it may be another one.
    fn goal(self, content: Content) -> (Rate, Option<f64>) {
        match self {
            Self::Usual => (Rate::usual(content), None),
            Self::Rate(rate) => (rate, None),
            Self::MinPsnr(db) => (Rate::usual(content), Some(db)),
        }
    }
}

/// What an image holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum WaveletRole {
    /// Base colour, emissive.
    #[default]
    Color,
    /// A gray picture, sRGB.
    Gray,
    /// A normal map in tangent space.
    Normal,
    /// One channel of data: occlusion, alpha masks.
    Mask,
    /// Three channels of data: metallic-roughness.
    Data,
}

impl WaveletRole {
    fn content(self) -> Content {
        match self {
            Self::Color | Self::Data => Content::Color,
            Self::Gray | Self::Mask => Content::Gray,
            Self::Normal => Content::Normal,
        }
    }

    fn color_space(self) -> ColorSpace {
        match self {
            Self::Color | Self::Gray => ColorSpace::Srgb,
            Self::Normal | Self::Mask | Self::Data => ColorSpace::Linear,
        }
    }
}

/// Why an image was not saved.
#[derive(Debug, Error)]
pub enum WaveletSaveError {
    /// Its pixels are in a format that cannot be read.
    #[error("cannot encode '{path}': its format {format:?} is neither 8 nor 16 bits a channel")]
    Format {
        /// The image's asset path.
        path: String,
        /// Its format.
        format: TextureFormat,
    },
    /// It is not one two-dimensional image with its pixels in main memory.
    #[error("cannot encode '{path}': it is an array, a cube or a volume, or its pixels are gone")]
    Shape {
        /// The image's asset path.
        path: String,
    },
    /// The role does not have the rate.
    #[error("cannot encode '{path}': {} is no rate for the role {role:?}; possible are {}", .rate.name(), possible(*role))]
    Rate {
        /// The image's asset path.
        path: String,
        /// The rate that was asked for.
        rate: Rate,
        /// The role.
        role: WaveletRole,
    },
    /// The encoder refused it.
    #[error("cannot encode '{path}': {source}")]
    Encode {
        /// The image's asset path.
        path: String,
        /// What is wrong with it.
        source: EncodeError,
    },
    /// The result could not be written.
    #[error("cannot write the wavelet texture of '{path}': {source}")]
    Io {
        /// The image's asset path.
        path: String,
        /// What the asset writer says.
        source: std::io::Error,
    },
}

fn possible(role: WaveletRole) -> String {
    let names: Vec<_> = Rate::of(role.content()).map(Rate::name).collect();
    names.join(", ")
}

impl WaveletSaverSettings {
    /// The bytes of the `.wtex` file of an image.
    ///
    /// # Errors
    /// See [`WaveletSaveError`]; `path` is what they name.
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
        let texels = texels(image).ok_or_else(|| WaveletSaveError::Shape { path: path() })?;
        let texels = texels.map_err(|format| WaveletSaveError::Format {
            path: path(),
            format,
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
            color_space,
            mips: self.mips,
            effort: self.effort,
            method: if self.one_fetch {
                Method::OneFetch
            } else {
                Method::Best
            },
        };
        let encoded = encode(&source, &settings, &|_, _| {});
        let encoded = encoded.map_err(|source| WaveletSaveError::Encode {
            path: path(),
            source,
        })?;
        Ok(file::write(&encoded))
    }
}

/// The texels of an image, all levels one after the other.
enum Texels<'a> {
    Gray8(&'a [u8]),
    Rgba8(&'a [[u8; 4]]),
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
            Self::Gray16(texels) => Pixels::Gray16(part(texels, start, length)),
            Self::Rgba16(texels) => Pixels::Rgba16(part(texels, start, length)),
        }
    }

    /// All levels that are there.
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

/// `None` where it is no plain image, the format where that is not understood.
fn texels(image: &Image) -> Option<Result<Texels<'_>, TextureFormat>> {
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
        TextureFormat::R16Unorm => Texels::Gray16(words().collect()),
        TextureFormat::Rgba16Unorm => {
            let words: Vec<u16> = words().collect();
            Texels::Rgba16(words.as_chunks::<4>().0.to_vec())
        }
        other => return Some(Err(other)),
    }))
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

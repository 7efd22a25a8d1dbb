//! Encoding of images when assets are processed, and its settings.

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

use super::loader::WaveletTextureLoader;
use crate::{
    codec::{
        angle::normal_blue,
        encoder::{EncodeError, encode},
        image::{ColorSpace, Content},
        layout,
        rate::Rate,
        reduce::reduced_rgba8,
        settings::{Effort, EncodeSettings, Formats, GrayChannel, Method},
        source::{OwnedPixels, Pixels, Source},
    },
    file,
    settings::WaveletLoaderSettings,
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
        let texels = Texels::of(image, content);
        let texels = texels.ok_or_else(|| WaveletSaveError::Shape { path: path() })?;
        let texels = texels.map_err(|format| {
            let path = path();
            match format.is_compressed() {
                true => WaveletSaveError::Blocks { path, format },
                false => WaveletSaveError::Format { path, format },
            }
        })?;
        let pixels = texels.pixels();
        let color_space = self.role.color_space();
        let size = [image.width(), image.height()];
        let reduced;
        let source = match self.max_size {
            Some(most) if size.iter().any(|s| *s > most.max(1)) => {
                reduced = reduced_rgba8(size, |i| pixels.get(i), most.max(1), color_space);
                Source::new(reduced.0, Pixels::Rgba8(&reduced.1))
            }
            _ => Source {
                size,
                levels: levels(pixels, size),
            },
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
    Given(Pixels<'a>),
    Converted(OwnedPixels),
}

impl<'a> Texels<'a> {
    /// `None` where the image is not two-dimensional or has no pixels in main memory, and its format as an error where
    /// that is not supported.
    fn of(image: &'a Image, content: Content) -> Option<Result<Self, TextureFormat>> {
        let data = image.data.as_deref()?;
        if image.texture_descriptor.size.depth_or_array_layers != 1 {
            return None;
        }
        let pairs = data.as_chunks::<2>().0;
        let words = || pairs.iter().map(|pair| u16::from_le_bytes(*pair));
        Some(Ok(match image.texture_descriptor.format {
            TextureFormat::R8Unorm => Self::Given(Pixels::Gray8(data)),
            TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => {
                Self::Given(Pixels::Rgba8(data.as_chunks::<4>().0))
            }
            TextureFormat::Rg8Unorm => {
                // The blue of normals is the Z of a unit vector, that of others 0.
                let blue = |pair| match content {
                    Content::Normal => normal_blue(pair),
                    _ => 0,
                };
                let texels = pairs.iter().map(|&[r, g]| [r, g, blue([r, g]), 255]);
                Self::Converted(OwnedPixels::Rgba8(texels.collect()))
            }
            TextureFormat::R16Unorm => Self::Converted(OwnedPixels::Gray16(words().collect())),
            TextureFormat::Rgba16Unorm => {
                let words: Vec<u16> = words().collect();
                Self::Converted(OwnedPixels::Rgba16(words.as_chunks::<4>().0.to_vec()))
            }
            other => return Some(Err(other)),
        }))
    }

    fn pixels(&self) -> Pixels<'_> {
        match self {
            Self::Given(pixels) => *pixels,
            Self::Converted(pixels) => pixels.pixels(),
        }
    }
}

/// Splits pixels into the levels that an image has.
fn levels(pixels: Pixels<'_>, size: [u32; 2]) -> Vec<Pixels<'_>> {
    let mut levels = Vec::new();
    let mut start = 0;
    while start < pixels.len() {
        let [width, height] = layout::mip_size(size, levels.len() as u32);
        let end = pixels.len().min(start + width as usize * height as usize);
        levels.push(pixels.part(start..end));
        start = end;
    }
    levels
}

/// Settings of [`WaveletSaver`], which are the `saver_settings` in a `.meta` file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaveletSaverSettings {
    /// The kind of data in the image. Default: [`WaveletRole::Color`].
    pub role: WaveletRole,
    /// The quality to encode at, as a rate or as a PSNR. Default: [`WaveletQuality::Usual`].
    pub quality: WaveletQuality,
    /// Whether colour keeps its alpha channel, which takes as many bits as luma. Default: `false`.
    pub alpha: bool,
    /// The `AlphaMode::Mask` cutoff of the material: mips then cover as much as the image does. Default: `None`,
    /// which is 0.5 in the role [`WaveletRole::Mask`] and otherwise leaves alpha as it is filtered.
    pub alpha_cutoff: Option<f32>,
    /// Time to spend on the search for the parameters. Default: [`Effort::Default`].
    pub effort: Effort,
    /// Whether to make mips where the image has none. Default: `true`.
    pub mips: bool,
    /// Longest side in pixels: larger images are halved until no side is longer. Default: `None`,
    /// no limit.
    pub max_size: Option<u32>,
    /// Whether to encode without prediction: a decoded pixel then takes one fetch of luma instead
    /// of five, at a lower quality. Default: `false`.
    pub one_fetch: bool,
    /// The kinds of textures to choose from, by their error. Default: [`Formats::Any`].
    pub formats: Formats,
    /// Compresses the file with Zstandard, at a level from 1 (fast) to 22 (small), which needs the feature
    /// `zstd_encode`. At level 19 the file is 11 to 20% smaller, and a game, which needs the feature `zstd`,
    /// takes 3 to 4 ms more per megapixel to load it. Default: `None`, uncompressed.
    pub zstd: Option<i32>,
}

impl Default for WaveletSaverSettings {
    fn default() -> Self {
        Self {
            role: WaveletRole::default(),
            quality: WaveletQuality::default(),
            alpha: false,
            alpha_cutoff: None,
            effort: Effort::default(),
            mips: true,
            max_size: None,
            one_fetch: false,
            formats: Formats::default(),
            zstd: None,
        }
    }
}

/// The quality of a texture, by its rate or by its error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum WaveletQuality {
    /// The default rate of the role: 2 bits per pixel for gray, 3 for colour, 4 for normals.
    #[default]
    Usual,
    /// The given rate, which must be one of the role's.
    Rate(Rate),
    /// The smallest rate of the role that reaches this PSNR in dB, measured on the encoded image
    /// itself, or the largest rate where none does. `docs/wavelet_tex.md` of the repository lists the
    /// PSNR of each rate on photographs.
    MinPsnr(f64),
}

impl WaveletQuality {
    /// The rate to encode with, and the PSNR in dB that replaces it by the smallest sufficient one.
    fn goal(self, content: Content) -> (Rate, Option<f64>) {
        match self {
            Self::Usual => (Rate::usual(content), None),
            Self::Rate(rate) => (rate, None),
            Self::MinPsnr(db) => (Rate::usual(content), Some(db)),
        }
    }
}

/// The kind of data in an image, which decides its content and its transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum WaveletRole {
    /// Base colour or emissive colour, in sRGB.
    #[default]
    Color,
    /// A gray picture, in sRGB.
    Gray,
    /// A normal map in tangent space.
    Normal,
    /// A mask that cuts parts out: red, as linear data.
    Mask,
    /// One channel of linear data, which is red: occlusion.
    Occlusion,
    /// Three channels of linear data: metallic-roughness.
    Data,
}

impl WaveletRole {
    fn content(self) -> Content {
        match self {
            Self::Color | Self::Data => Content::Color,
            Self::Gray | Self::Mask | Self::Occlusion => Content::Gray,
            Self::Normal => Content::Normal,
        }
    }

    /// The channels of which gray is made.
    fn gray(self) -> GrayChannel {
        match self {
            Self::Mask | Self::Occlusion => GrayChannel::Red,
            Self::Color | Self::Gray | Self::Normal | Self::Data => GrayChannel::Luma,
        }
    }

    /// The cutoff where none is set.
    fn usual_cutoff(self) -> Option<f32> {
        (self == Self::Mask).then_some(0.5)
    }

    fn color_space(self) -> ColorSpace {
        match self {
            Self::Color | Self::Gray => ColorSpace::Srgb,
            Self::Normal | Self::Mask | Self::Occlusion | Self::Data => ColorSpace::Linear,
        }
    }
}

#[cfg(all(test, not(feature = "zstd_encode")))]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        prelude::default,
        render::render_resource::{Extent3d, TextureDimension},
    };

    use super::*;

    #[test]
    fn zstandard_needs_its_feature() {
        let image = Image::new_fill(
            Extent3d::default(),
            TextureDimension::D2,
            &[0; 4],
            TextureFormat::Rgba8Unorm,
            RenderAssetUsages::all(),
        );
        let settings = WaveletSaverSettings {
            zstd: Some(19),
            ..default()
        };
        let error = settings.encode(&image, "x.png").expect_err("refused");
        assert!(matches!(error, WaveletSaveError::ZstdDisabled { path } if path == "x.png"));
    }
}

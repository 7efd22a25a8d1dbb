//! The loader of `.wtex` files.

use std::sync::Once;

use bevy::{
    asset::{AssetLoader, LoadContext, io::Reader},
    log::warn,
    reflect::TypePath,
};
use thiserror::Error;

use super::texture::{MipAtlas, WaveletTexture};
use crate::{
    codec::{image::WaveletImage, layout::mip_size},
    file::{self, ReadError},
    settings::{WaveletLoaderSettings, WaveletStorage},
};

/// Loads [`WaveletTexture`]s. Their images have the labels `luma`, `detail`, `chroma`, `plain`, `decoded` and `preview`.
#[derive(TypePath)]
pub struct WaveletTextureLoader {
    /// The feature or limit that the device lacks to sample blocks.
    lack: Option<BlockLack>,
    warned: Once,
    /// Largest width and height of a texture on the device, in texels.
    max_texture_size: u32,
    makes_previews: bool,
}

/// What a device lacks to sample the blocks of wavelet textures, which are therefore decoded to RGBA8 on load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum BlockLack {
    /// No texture has blocks.
    #[error("the adapter lacks TEXTURE_COMPRESSION_BC: wavelet textures are")]
    Bc,
    /// A material can have one texture for each map, but not all planes of wavelet textures. Those that have one
    /// texture, such as normal maps, keep their blocks.
    #[error(
        "the device binds at most {limit} textures in a stage of a shader (max_sampled_textures_per_shader_stage), and \
         a material with all planes of wavelet textures needs {needed}: wavelet textures of several planes are"
    )]
    Textures {
        /// The device's `max_sampled_textures_per_shader_stage`.
        limit: u32,
        /// Textures of a material, with all of its maps, and of Bevy's view.
        needed: u32,
    },
}

/// The reason why a texture was not loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
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
    /// No mip level fits the device, or can be decoded within [`DECODE_BUDGET`].
    #[error(
        "cannot load wavelet texture '{path}': it is {} x {} pixels without smaller mip levels, and a \
         texture that is decoded on load has at most {limit} x {limit}, and {DECODED_PIXELS} pixels in all: encode it \
         with mips",
        size[0],
        size[1]
    )]
    TooLarge {
        /// Asset path of the file.
        path: String,
        /// Width and height of the image in pixels.
        size: [u32; 2],
        /// The device's `max_texture_dimension_2d`.
        limit: u32,
    },
}

/// Bytes of memory that the decoding of a texture on load takes at most. Larger mip levels are left out.
///
/// A file states the sizes of its blocks, up to 384 MiB for an image of 16384 x 16384 pixels, which are there beside it.
pub const DECODE_BUDGET: u64 = 640 << 20;

/// Bytes that it takes for each pixel: planes, texels of blocks, decoded pixels and those of the texture.
pub const DECODE_BYTES_PER_PIXEL: u64 = 40;

/// Pixels of the largest level that is decoded, which are those of 4096 x 4096.
const DECODED_PIXELS: u64 = DECODE_BUDGET / DECODE_BYTES_PER_PIXEL;

impl WaveletTextureLoader {
    /// Makes a loader for a device that lacks this to sample blocks, or nothing. Textures whose coefficients do not
    /// fit `max_texture_size`, the device's `max_texture_dimension_2d`, are decoded to RGBA8 on load, too; if the
    /// pixels do not fit either, the largest mip levels that do not are left out.
    pub fn new(lack: Option<BlockLack>, max_texture_size: u32) -> Self {
        Self {
            lack,
            warned: Once::new(),
            max_texture_size,
            makes_previews: false,
        }
    }

    /// Whether textures have a [`WaveletTexture::preview`]; without this call, they have none.
    pub fn with_previews(mut self, makes_previews: bool) -> Self {
        self.makes_previews = makes_previews;
        self
    }

    fn fits(&self, size: [u32; 2]) -> bool {
        size.iter().all(|side| *side <= self.max_texture_size)
    }

    /// How an image is represented, and from which level on where it is decoded.
    fn representation(
        &self,
        image: &WaveletImage,
        settings: &WaveletLoaderSettings,
        path: &str,
    ) -> Result<(WaveletStorage, u32), WaveletLoadError> {
        let storage = self.storage(image, settings);
        let atlases = image.groups().map(|group| MipAtlas::of(image, group));
        let plain = image.plain().map(|plain| plain.size);
        let mut sizes = atlases.map(|atlas| atlas.size).chain(plain);
        let too_large = sizes.find(|size| !self.fits(*size));
        let most = settings.max_size.map_or(u32::MAX, |most| most.max(1));
        let is_wanted = |level: &u32| mip_size(image.size, *level).iter().all(|s| *s <= most);
        // The reader has left out what is not wanted, unless the blocks of a level cannot be the first.
        let begins_later = image.levels > 1 && !is_wanted(&0);
        if storage == WaveletStorage::Blocks && too_large.is_none() && !begins_later {
            return Ok((storage, 0));
        }
        let limit = self.max_texture_size;
        let is_possible = |level: &u32| {
            let size = mip_size(image.size, *level);
            let pixels = size.map(u64::from).iter().product::<u64>();
            self.fits(size) && pixels <= DECODED_PIXELS
        };
        let first = (0..image.levels).find(|level| is_possible(level) && is_wanted(level));
        let first = first.or_else(|| (0..image.levels).rfind(is_possible));
        let first = first.ok_or_else(|| WaveletLoadError::TooLarge {
            path: path.into(),
            size: image.size,
            limit,
        })?;
        if let (WaveletStorage::Blocks, Some([w, h])) = (storage, too_large) {
            warn!(
                "wavelet texture '{path}' is decoded on load to RGBA8, which takes 6 to 16 times the \
                 memory: its coefficients with all mips take {w} x {h} texels, and a texture of the \
                 device has at most {limit} x {limit}"
            );
        }
        if first > 0 && !is_possible(&(first - 1)) {
            let [w, h] = mip_size(image.size, first);
            warn!(
                "wavelet texture '{path}' is shown at {w} x {h} pixels instead of {} x {}: a texture \
                 that is decoded on load has at most {limit} x {limit}, and {DECODED_PIXELS} pixels in all",
                image.size[0], image.size[1]
            );
        }
        Ok((WaveletStorage::Decoded, first))
    }

    fn storage(&self, image: &WaveletImage, settings: &WaveletLoaderSettings) -> WaveletStorage {
        let lack = self.lack.filter(|lack| match lack {
            BlockLack::Bc => true,
            BlockLack::Textures { .. } => {
                let textures = image.groups().map(|group| group.textures.len());
                textures.sum::<usize>() > 1
            }
        });
        if let Some(lack) = lack {
            self.warned.call_once(|| {
                warn!("{lack} decoded on load to RGBA8 and take 6 to 16 times the memory");
            });
        }
        match lack.is_some() || settings.decode_on_load {
            true => WaveletStorage::Decoded,
            false => WaveletStorage::Blocks,
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
        let image = match file::read_at_most(&bytes, settings.max_size) {
            Ok(image) => image,
            Err(source) => return Err(WaveletLoadError::Read { path, source }),
        };
        let (storage, first_level) = self.representation(&image, settings, &path)?;
        let add = |label: &str, image| load_context.add_labeled_asset(label.to_string(), image);
        let previews = self.makes_previews;
        Ok(WaveletTexture::new(
            &image,
            storage,
            first_level,
            previews,
            add,
        ))
    }

    fn extensions(&self) -> &[&str] {
        &[file::EXTENSION]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::{
        axes::ColorAxes,
        image::{ColorSpace, Content, Payload, PlaneGroup, WaveletPlanes},
        layout::level_count,
        packing::Packing,
    };

    /// An image without its blocks, which decide nothing here.
    fn image(size: u32, levels: u32) -> WaveletImage {
        WaveletImage {
            content: Content::Gray,
            color_space: ColorSpace::Linear,
            size: [size; 2],
            levels,
            payload: Payload::Wavelet(WaveletPlanes {
                axes: ColorAxes::YCOCG,
                luma: PlaneGroup {
                    subsampling: 0,
                    packing: Packing::Bc3,
                    codings: Vec::new(),
                    textures: vec![Vec::new()],
                },
                chroma: None,
            }),
        }
    }

    #[test]
    fn decoding_stays_within_its_budget() {
        let without_bc = WaveletTextureLoader::new(Some(BlockLack::Bc), 16384);
        let settings = WaveletLoaderSettings::default();
        let of = |image: &WaveletImage| without_bc.representation(image, &settings, "a.wtex");
        for (size, first) in [(4096, 0), (8192, 1), (16384, 2)] {
            let found = of(&image(size, level_count([size; 2]))).expect("levels that fit");
            assert_eq!(found, (WaveletStorage::Decoded, first), "{size}");
        }
        let error = of(&image(16384, 1)).expect_err("too large").to_string();
        for part in ["a.wtex", "16384 x 16384", "16777216 pixels", "with mips"] {
            assert!(error.contains(part), "{part}: {error}");
        }
        // Blocks are not decoded.
        let with_bc = WaveletTextureLoader::new(None, 32768);
        let found = with_bc.representation(&image(16384, 15), &settings, "a.wtex");
        assert_eq!(found.expect("fits"), (WaveletStorage::Blocks, 0));
    }

    #[test]
    fn the_longest_side_counts_for_what_is_decoded_too() {
        let loader = WaveletTextureLoader::new(Some(BlockLack::Bc), 16384);
        let first = |levels, max_size| {
            let settings = WaveletLoaderSettings {
                max_size,
                ..WaveletLoaderSettings::default()
            };
            let found = loader.representation(&image(512, levels), &settings, "a.wtex");
            found.expect("levels that fit").1
        };
        assert_eq!(first(10, None), 0);
        assert_eq!(first(10, Some(100)), 3);
        assert_eq!(first(10, Some(0)), 9);
        // As small as its levels allow.
        assert_eq!(first(2, Some(100)), 1);
        assert_eq!(first(1, Some(100)), 0);
    }
}

//! The asset: what a shader must know, and the images that it reads.

use bevy::{
    asset::{Asset, Assets, Handle, RenderAssetUsages},
    image::{Image, ImageSampler},
    reflect::TypePath,
    render::render_resource::{
        Extent3d, TextureDataOrder, TextureDescriptor, TextureDimension, TextureFormat,
        TextureUsages, TextureViewDescriptor, TextureViewDimension,
    },
};

use crate::codec::{
    decoder::decode,
    image::{ColorSpace, Content, WaveletImage},
    quantizer::PlaneCoding,
};

/// A wavelet texture, loaded from a `.wtex` file or made with [`WaveletTexture::add`].
#[derive(Asset, Clone, Debug, TypePath)]
pub struct WaveletTexture {
    /// What it holds.
    pub content: Content,
    /// How its values relate to light.
    pub color_space: ColorSpace,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Number of mip levels, at least 1.
    pub levels: u32,
    /// How it is kept on the GPU.
    pub storage: WaveletStorage,
    /// How the coefficients of each plane are stored.
    pub codings: Vec<PlaneCoding>,
    /// The array textures: one for each plane group (luma, chroma), or one of decoded pixels.
    #[dependency]
    pub images: Vec<Handle<Image>>,
    /// Bytes that the images take on the GPU.
    pub gpu_bytes: usize,
}

/// How a texture is kept on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WaveletStorage {
    /// As BC3 blocks; the adapter needs `TEXTURE_COMPRESSION_BC`.
    #[default]
    Blocks,
    /// As RGBA8, decoded on the CPU: looks the same, 8 to 16 times as large.
    Decoded,
}

impl WaveletTexture {
    /// Adds a texture to an app at run time.
    pub fn add(
        image: &WaveletImage,
        storage: WaveletStorage,
        textures: &mut Assets<Self>,
        images: &mut Assets<Image>,
    ) -> Handle<Self> {
        textures.add(Self::new(image, storage, |_, image| images.add(image)))
    }

    /// Makes the asset; `add_image` receives each image and its label.
    pub(super) fn new(
        image: &WaveletImage,
        storage: WaveletStorage,
        mut add_image: impl FnMut(&'static str, Image) -> Handle<Image>,
    ) -> Self {
        const LABELS: [&str; 2] = ["luma", "chroma"];
        let (images, gpu_bytes) = match storage {
            WaveletStorage::Blocks => {
                let images = (0..image.groups.len())
                    .map(|group| add_image(LABELS[group], block_image(image, group)))
                    .collect();
                (images, image.gpu_bytes())
            }
            WaveletStorage::Decoded => {
                let decoded = decoded_image(image);
                let bytes = decoded.data.as_ref().map_or(0, Vec::len);
                (vec![add_image("decoded", decoded)], bytes)
            }
        };
        Self {
            content: image.content,
            color_space: image.color_space,
            size: image.size,
            levels: image.levels,
            storage,
            codings: image
                .groups
                .iter()
                .flat_map(|g| g.codings.iter().copied())
                .collect(),
            images,
            gpu_bytes,
        }
    }
}

/// The BC3 array texture of a plane group.
fn block_image(image: &WaveletImage, group: usize) -> Image {
    let layers = image.groups[group].codings.len() as u32;
    array_image(
        image.texture_size(group),
        layers,
        image.levels,
        // Coefficients, not colours: never an sRGB format.
        TextureFormat::Bc3RgbaUnorm,
        image.groups[group].blocks.clone(),
    )
}

/// All levels decoded, as the shader would see them before it linearises.
fn decoded_image(image: &WaveletImage) -> Image {
    let pixels: Vec<u8> = (0..image.levels)
        .flat_map(|level| decode(image, level).to_rgba8(image.content))
        .flatten()
        .collect();
    array_image(
        image.size,
        1,
        image.levels,
        TextureFormat::Rgba8Unorm,
        pixels,
    )
}

fn array_image(
    [width, height]: [u32; 2],
    layers: u32,
    levels: u32,
    format: TextureFormat,
    data: Vec<u8>,
) -> Image {
    Image {
        data: Some(data),
        data_order: TextureDataOrder::MipMajor,
        texture_descriptor: TextureDescriptor {
            label: Some("wavelet_texture"),
            size: Extent3d {
                width,
                height,
                depth_or_array_layers: layers,
            },
            mip_level_count: levels,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        },
        sampler: ImageSampler::nearest(),
        texture_view_descriptor: Some(TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2Array),
            ..Default::default()
        }),
        asset_usage: RenderAssetUsages::RENDER_WORLD,
        copy_on_resize: false,
    }
}

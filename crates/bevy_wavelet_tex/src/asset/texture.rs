//! The asset: the parameters that a shader needs, and the images that it samples.

use bevy::{
    asset::{Asset, Assets, Handle, RenderAssetUsages, UntypedAssetId, VisitAssetDependencies},
    image::{Image, ImageSampler},
    reflect::TypePath,
    render::render_resource::{
        Extent3d, TextureDataOrder, TextureDescriptor, TextureDimension, TextureFormat,
        TextureUsages, TextureViewDescriptor, TextureViewDimension,
    },
};

use crate::{
    codec::{
        blocks::BlockFormat,
        decoder::decode,
        image::{ColorSpace, Content, PlaneGroup, WaveletImage},
        layout,
        packing::Packing,
        quantizer::PlaneCoding,
    },
    settings::WaveletStorage,
};

/// A wavelet texture, loaded from a `.wtex` file or made with [`WaveletTexture::add`].
#[derive(Asset, Clone, Debug, TypePath)]
pub struct WaveletTexture {
    /// The kind of data in the texture.
    pub content: Content,
    /// Transfer function of the values.
    pub color_space: ColorSpace,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Number of mip levels, at least 1.
    pub levels: u32,
    /// Representation on the GPU.
    pub storage: WaveletStorage,
    /// Parameters of the groups of planes: luma (with alpha), gray or normals, then chroma.
    pub groups: Vec<TextureGroup>,
    /// The array textures of the planes.
    #[dependency]
    pub images: Parts<Handle<Image>>,
    /// Bytes that the images take on the GPU.
    pub gpu_bytes: usize,
}

/// The parameters of a group of planes that a shader needs.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureGroup {
    /// How often the image size is halved to get the size of the planes.
    pub subsampling: u32,
    /// How the planes are packed into textures.
    pub packing: Packing,
    /// How the values of each plane are stored.
    pub codings: Vec<PlaneCoding>,
}

/// The images of a texture; a part that the texture does not have is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parts<T> {
    /// Luma (with alpha in a second layer), gray, X and Y of normals, or the decoded pixels.
    pub luma: Option<T>,
    /// The detail bands, where they have a texture of their own.
    pub detail: Option<T>,
    /// Chroma: Co and Cg.
    pub chroma: Option<T>,
}

/// One of the [`Parts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Luma,
    Detail,
    Chroma,
}

impl<T> Parts<T> {
    pub(crate) fn as_ref(&self) -> Parts<&T> {
        Parts {
            luma: self.luma.as_ref(),
            detail: self.detail.as_ref(),
            chroma: self.chroma.as_ref(),
        }
    }

    pub(crate) fn map<U>(self, f: impl Fn(T) -> U) -> Parts<U> {
        Parts {
            luma: self.luma.map(&f),
            detail: self.detail.map(&f),
            chroma: self.chroma.map(&f),
        }
    }

    /// Iterates over the parts that the texture has.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        [&self.luma, &self.detail, &self.chroma]
            .into_iter()
            .flatten()
    }
}

impl<T: Copy> Parts<T> {
    pub(crate) fn part(&self, part: Part) -> Option<T> {
        match part {
            Part::Luma => self.luma,
            Part::Detail => self.detail,
            Part::Chroma => self.chroma,
        }
    }
}

impl VisitAssetDependencies for Parts<Handle<Image>> {
    fn visit_dependencies(&self, visit: &mut impl FnMut(UntypedAssetId)) {
        self.iter().for_each(|image| visit(image.id().untyped()));
    }
}

impl WaveletTexture {
    /// Adds a texture and its images to an app at run time.
    pub fn add(
        image: &WaveletImage,
        storage: WaveletStorage,
        textures: &mut Assets<Self>,
        images: &mut Assets<Image>,
    ) -> Handle<Self> {
        textures.add(Self::new(image, storage, |_, image| images.add(image)))
    }

    /// Makes the asset. `add_image` receives each image and its label.
    pub(super) fn new(
        image: &WaveletImage,
        storage: WaveletStorage,
        mut add_image: impl FnMut(&'static str, Image) -> Handle<Image>,
    ) -> Self {
        let (images, gpu_bytes) = match storage {
            WaveletStorage::Blocks => (block_images(image, add_image), image.gpu_bytes()),
            WaveletStorage::Decoded => {
                let decoded = decoded_image(image);
                let bytes = decoded.data.as_ref().map_or(0, Vec::len);
                let images = Parts {
                    luma: Some(add_image("decoded", decoded)),
                    ..Parts::default()
                };
                (images, bytes)
            }
        };
        let groups = image.groups.iter().map(|group| TextureGroup {
            subsampling: group.subsampling,
            packing: group.packing,
            codings: group.codings.clone(),
        });
        Self {
            content: image.content,
            color_space: image.color_space,
            size: image.size,
            levels: image.levels,
            storage,
            groups: groups.collect(),
            images,
            gpu_bytes,
        }
    }

    /// Returns whether the textures contain no padding at any level, so that a sampler can repeat
    /// them. Only then can the texture unit filter them directly.
    pub fn is_whole(&self) -> bool {
        if self.storage == WaveletStorage::Decoded {
            return true;
        }
        self.groups.iter().all(|group| {
            (0..self.levels).all(|level| {
                let size = layout::mip_size(self.size, level);
                let whole = size.map(|s| s % (1 << group.subsampling) == 0);
                let plane = layout::plane_size(size, group.subsampling);
                let first = layout::plane_size(self.size, group.subsampling);
                let texture = layout::mip_size(layout::texture_size(group.packing, first), level);
                let texels = layout::texel_size(group.packing, plane);
                let halves = !group.packing.is_wavelet() || plane.iter().all(|s| s % 2 == 0);
                // The last levels consist of edges only, and filtering across their padding is not
                // visible.
                level > 0 && size.iter().any(|s| *s < 8)
                    || texels == texture && halves && whole == [true, true]
            })
        })
    }
}

/// Makes the array textures of all groups.
fn block_images(
    image: &WaveletImage,
    mut add_image: impl FnMut(&'static str, Image) -> Handle<Image>,
) -> Parts<Handle<Image>> {
    let mut add = |group: usize, texture: usize, label| {
        image
            .groups
            .get(group)
            .filter(|group| texture < group.textures.len())
            .map(|group| add_image(label, block_image(image, group, texture)))
    };
    Parts {
        luma: add(0, 0, "luma"),
        detail: add(0, 1, "detail"),
        chroma: add(1, 0, "chroma"),
    }
}

/// Makes the array texture of a group's blocks.
fn block_image(image: &WaveletImage, group: &PlaneGroup, texture: usize) -> Image {
    // These are coefficients, not colours, so the format is never sRGB.
    let format = match group.packing.formats()[texture] {
        BlockFormat::Bc1 => TextureFormat::Bc1RgbaUnorm,
        BlockFormat::Bc3 => TextureFormat::Bc3RgbaUnorm,
        BlockFormat::Bc4 => TextureFormat::Bc4RUnorm,
        BlockFormat::Bc7 => TextureFormat::Bc7RgbaUnorm,
    };
    array_image(
        group.texture_size(image.size),
        group.layers() as u32,
        image.levels,
        format,
        group.textures[texture].clone(),
    )
}

/// Decodes all levels to the values that the shader reads before it linearises.
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

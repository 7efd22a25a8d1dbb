//! The asset: the parameters that a shader needs, the images that it samples, and the placement of mip levels in these.

use bevy::{
    asset::{Asset, Assets, Handle, RenderAssetUsages, UntypedAssetId, VisitAssetDependencies},
    image::{Image, ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    reflect::{Reflect, impl_reflect_opaque},
    render::render_resource::{
        Extent3d, TextureDataOrder, TextureDescriptor, TextureDimension, TextureFormat,
        TextureUsages, TextureViewDescriptor, TextureViewDimension,
    },
};

use crate::{
    codec::{
        axes::ColorAxes,
        blocks::BlockFormat,
        decoder::decode,
        image::{ColorSpace, Content, Payload, PlaneGroup, WaveletImage},
        layout,
        packing::Packing,
        plain::PlainTexture,
        quantizer::PlaneCoding,
    },
    settings::WaveletStorage,
};

/// A wavelet texture, loaded from a `.wtex` file or made with [`WaveletTexture::add`].
#[derive(Asset, Clone, Debug, Reflect)]
#[reflect(Clone, Debug)]
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
    /// The parameters with which a shader decodes the texels.
    pub parameters: TextureParameters,
    /// The array textures of the planes.
    #[dependency]
    pub images: Parts<Handle<Image>>,
    /// The levels of at most 64 x 64 pixels as an image, for plugins that do not run the material's shader; see
    /// [`MaterialImages`](bevy_frugal_hooks::MaterialImages). `None` where there is no such plugin, for normals, and without
    /// such levels.
    #[dependency]
    pub preview: Option<Handle<Image>>,
    /// Bytes that the images take on the GPU, without the preview.
    pub gpu_bytes: usize,
}

/// The parameters of a texture that a shader needs.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub enum TextureParameters {
    /// The parameters of wavelet planes, as in [`WaveletPlanes`](crate::codec::image::WaveletPlanes).
    Wavelet {
        /// The axes of colour along which luma and chroma are stored; those of YCoCg without colour.
        axes: ColorAxes,
        /// Luma (with alpha), gray, or X and Y of normals.
        luma: TextureGroup,
        /// Chroma, of textures in colour.
        chroma: Option<TextureGroup>,
    },
    /// Those of a texture without a wavelet.
    Plain(PlainParameters),
}

impl TextureParameters {
    fn new(image: &WaveletImage) -> Self {
        match &image.payload {
            Payload::Wavelet(planes) => Self::Wavelet {
                axes: planes.axes,
                luma: TextureGroup::new(&planes.luma),
                chroma: planes.chroma.as_ref().map(TextureGroup::new),
            },
            Payload::Plain(plain) => Self::Plain(PlainParameters {
                format: plain.format,
                is_scaled: plain.is_scaled(image.size),
                is_padded: plain.is_padded(image.size),
            }),
        }
    }

    /// The groups of planes: luma, then chroma if there is any; `None` where the texture is a plain one.
    pub(crate) fn groups(&self) -> [Option<&TextureGroup>; 2] {
        match self {
            Self::Wavelet { luma, chroma, .. } => [Some(luma), chroma.as_ref()],
            Self::Plain(_) => [None; 2],
        }
    }

    /// The axes of colour: those of YCoCg where nothing is stored along others.
    pub(crate) fn axes(&self) -> ColorAxes {
        match self {
            Self::Wavelet { axes, .. } => *axes,
            Self::Plain(_) => ColorAxes::YCOCG,
        }
    }
}

/// The parameters of a group of planes that a shader needs.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct TextureGroup {
    /// How often the image size is halved to get the size of the planes.
    pub subsampling: u32,
    /// How the planes are packed into textures.
    pub packing: Packing,
    /// How the values of each plane are stored.
    pub codings: Vec<PlaneCoding>,
}

impl TextureGroup {
    fn new(group: &PlaneGroup) -> Self {
        Self {
            subsampling: group.subsampling,
            packing: group.packing,
            codings: group.codings.clone(),
        }
    }
}

/// The parameters of a plain texture that a shader needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub struct PlainParameters {
    /// Format of the blocks.
    pub format: BlockFormat,
    /// Whether it has fewer texels than the image has pixels.
    pub is_scaled: bool,
    /// Whether it has more texels than the image has pixels, beyond the last row or column.
    pub is_padded: bool,
}

/// The images of a texture; a part that the texture does not have is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Reflect)]
pub struct Parts<T> {
    /// Luma (with alpha in a second layer), gray, X and Y of normals, the plain texture, or the decoded
    /// pixels.
    pub luma: Option<T>,
    /// The detail bands, where they have a texture of their own.
    pub detail: Option<T>,
    /// Chroma: Co and Cg.
    pub chroma: Option<T>,
}

impl<T> Parts<T> {
    /// Luma, detail and chroma.
    pub(crate) fn all(&self) -> [Option<&T>; 3] {
        [&self.luma, &self.detail, &self.chroma].map(Option::as_ref)
    }

    /// Iterates over the parts that the texture has.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.all().into_iter().flatten()
    }
}

impl VisitAssetDependencies for Parts<Handle<Image>> {
    fn visit_dependencies(&self, visit: &mut impl FnMut(UntypedAssetId)) {
        self.iter().for_each(|image| visit(image.id().untyped()));
    }
}

impl WaveletTexture {
    /// Adds a texture and its images to an app at run time, with a preview.
    ///
    /// Devices may not have blocks of all kinds: [`storage_on`](crate::material::storage_on) returns a storage that the
    /// device has.
    pub fn add(
        image: &WaveletImage,
        storage: WaveletStorage,
        textures: &mut Assets<Self>,
        images: &mut Assets<Image>,
    ) -> Handle<Self> {
        textures.add(Self::new(image, storage, 0, true, |_, image| {
            images.add(image)
        }))
    }

    /// Makes the asset. `first_level` is the largest level that a decoded texture has. `add_image`
    /// receives each image and its label.
    pub(super) fn new(
        image: &WaveletImage,
        storage: WaveletStorage,
        first_level: u32,
        has_preview: bool,
        mut add_image: impl FnMut(&'static str, Image) -> Handle<Image>,
    ) -> Self {
        let mut gpu_bytes = 0;
        let mut add = |label, image: Image| {
            gpu_bytes += image.data.as_ref().map_or(0, Vec::len);
            add_image(label, image)
        };
        let images = match (storage, &image.payload) {
            (WaveletStorage::Decoded, _) => Parts {
                luma: Some(add("decoded", decoded_image(image, first_level))),
                ..Parts::default()
            },
            (WaveletStorage::Blocks, Payload::Plain(plain)) => Parts {
                luma: Some(add("plain", plain_image(image, plain))),
                ..Parts::default()
            },
            (WaveletStorage::Blocks, Payload::Wavelet(planes)) => {
                let mut part = |group: Option<&PlaneGroup>, texture: usize, label| {
                    let group = group.filter(|group| texture < group.textures.len())?;
                    Some(add(label, block_image(image, group, texture)))
                };
                Parts {
                    luma: part(Some(&planes.luma), 0, "luma"),
                    detail: part(Some(&planes.luma), 1, "detail"),
                    chroma: part(planes.chroma.as_ref(), 0, "chroma"),
                }
            }
        };
        let preview = has_preview.then(|| preview_image(image)).flatten();
        let preview = preview.map(|preview| add_image("preview", preview));
        Self {
            content: image.content,
            color_space: image.color_space,
            size: layout::mip_size(image.size, first_level),
            levels: image.levels - first_level,
            storage,
            parameters: TextureParameters::new(image),
            images,
            preview,
            gpu_bytes,
        }
    }

    /// Where the mip levels of a group's planes lie in its textures.
    pub(crate) fn atlas(&self, group: &TextureGroup) -> MipAtlas {
        MipAtlas::new(self.levels, |level| {
            layout::texture_level_size(group.packing, self.size, group.subsampling, level)
        })
    }
}

/// Makes the array texture of a group's blocks.
fn block_image(image: &WaveletImage, group: &PlaneGroup, texture: usize) -> Image {
    let atlas = MipAtlas::of(image, group);
    let blocks = atlas.arranged(image, group, texture);
    // These are coefficients, not colours, so the format is never sRGB.
    let format = texture_format(group.packing.formats()[texture], false);
    array_image(atlas.size, group.layers() as u32, 1, format, blocks)
}

/// Makes the texture of an image without a wavelet, with a mip chain.
fn plain_image(image: &WaveletImage, plain: &PlainTexture) -> Image {
    let is_srgb = plain.is_srgb(image.content, image.color_space, image.size);
    let format = texture_format(plain.format, is_srgb);
    array_image(plain.size, 1, image.levels, format, plain.blocks.clone())
}

fn texture_format(format: BlockFormat, is_srgb: bool) -> TextureFormat {
    match format {
        BlockFormat::Bc1 if is_srgb => TextureFormat::Bc1RgbaUnormSrgb,
        BlockFormat::Bc7 if is_srgb => TextureFormat::Bc7RgbaUnormSrgb,
        BlockFormat::Bc1 => TextureFormat::Bc1RgbaUnorm,
        BlockFormat::Bc3 => TextureFormat::Bc3RgbaUnorm,
        BlockFormat::Bc4 => TextureFormat::Bc4RUnorm,
        BlockFormat::Bc5 => TextureFormat::Bc5RgUnorm,
        BlockFormat::Bc7 => TextureFormat::Bc7RgbaUnorm,
    }
}

/// Decodes all levels from one on to the values that the texture unit filters.
fn decoded_image(image: &WaveletImage, first_level: u32) -> Image {
    let pixels: Vec<u8> = (first_level..image.levels)
        .flat_map(|level| decode(image, level).to_rgba8(image.content))
        .flatten()
        .collect();
    let srgb = image.color_space == ColorSpace::Srgb && image.content != Content::Normal;
    let format = if srgb {
        TextureFormat::Rgba8UnormSrgb
    } else {
        TextureFormat::Rgba8Unorm
    };
    let size = layout::mip_size(image.size, first_level);
    array_image(size, 1, image.levels - first_level, format, pixels)
}

/// Most pixels of a preview along an axis.
const PREVIEW_SIZE: u32 = 64;

/// Decodes the levels that are small enough.
fn preview_image(image: &WaveletImage) -> Option<Image> {
    let is_small = |level: &u32| {
        let size = layout::mip_size(image.size, *level);
        size.iter().all(|side| *side <= PREVIEW_SIZE)
    };
    let first_level = (0..image.levels).find(is_small)?;
    (image.content != Content::Normal).then(|| Image {
        sampler: ImageSampler::Descriptor(ImageSamplerDescriptor {
            address_mode_u: ImageAddressMode::Repeat,
            address_mode_v: ImageAddressMode::Repeat,
            ..ImageSamplerDescriptor::linear()
        }),
        texture_view_descriptor: None,
        ..decoded_image(image, first_level)
    })
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

/// Where the mip levels of a group of planes lie in its textures. All lengths are in texels, apart from
/// `stack`.
///
/// The texture unit gathers texels from the first level of a texture only (WGSL's `textureGather`
/// as well as the APIs below it), and a lookup needs 4 x 4 values of the low band from any level. So
/// all levels lie in one: level 1 beside level 0, or below it where that takes less memory, and the
/// others after level 1, in whole 4 x 4 blocks. A square texture takes 3/2 of the memory of its level
/// 0 instead of the 4/3 of a mip chain.
///
/// A shader computes where a level lies: with `b` the blocks that all but level 0 have along their
/// axis, level n begins after `stack - (2 stack >> n)` of them, which for powers of two is exactly the
/// sum of those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MipAtlas {
    /// Size of the textures.
    pub(crate) size: [u32; 2],
    /// Position of level 1.
    pub(crate) second: [u32; 2],
    /// The step from a block to the next along the axis in which levels follow level 1.
    pub(crate) block: [u32; 2],
    /// Level n begins `stack - (2 stack >> n)` blocks after level 1.
    pub(crate) stack: u32,
    /// Levels after this one are one more block further each: they are smaller than a block.
    pub(crate) tail: u32,
}

impl MipAtlas {
    /// `level_size` is that of each level in texels.
    pub(crate) fn new(levels: u32, level_size: impl Fn(u32) -> [u32; 2]) -> Self {
        let blocks = |level| level_size(level).map(|s| s.div_ceil(4));
        let [beside, below] = [1, 0].map(|axis| Self::along(levels, &blocks, axis));
        let area = |atlas: &Self| u64::from(atlas.size[0]) * u64::from(atlas.size[1]);
        match area(&below) < area(&beside) {
            true => below,
            false => beside,
        }
    }

    /// That of a group of planes.
    pub(crate) fn of(image: &WaveletImage, group: &PlaneGroup) -> Self {
        Self::new(image.levels, |level| {
            group.texture_level_size(image.size, level)
        })
    }

    /// With levels of these whole blocks after level 1 along an axis.
    fn along(levels: u32, blocks: &impl Fn(u32) -> [u32; 2], axis: usize) -> Self {
        let mut atlas = Self {
            size: blocks(0).map(|blocks| 4 * blocks),
            ..Self::default()
        };
        if levels == 1 {
            return atlas;
        }
        let across = 1 - axis;
        let needed = |level: u32| blocks(level)[axis];
        let fits = |stack: &u32| {
            let tail = tail(*stack);
            (1..levels.min(tail)).all(|n| (stack >> (n - 1)) - (stack >> n) >= needed(n))
        };
        let most = needed(0).next_power_of_two();
        atlas.stack = (needed(0)..most).find(fits).unwrap_or(most);
        atlas.tail = tail(atlas.stack);
        atlas.second[across] = atlas.size[across];
        atlas.block[axis] = 4;
        let last = levels - 1;
        let end = atlas.origin(last)[axis] + 4 * needed(last);
        atlas.size[axis] = atlas.size[axis].max(end);
        atlas.size[across] += 4 * blocks(1)[across];
        atlas
    }

    /// Position of a level.
    pub(crate) fn origin(&self, level: u32) -> [u32; 2] {
        if level == 0 {
            return [0; 2];
        }
        let blocks = self.stack - ((2 * self.stack) >> level) + level.saturating_sub(self.tail);
        [0, 1].map(|axis| self.second[axis] + self.block[axis] * blocks)
    }

    /// The blocks of a texture of a group, layer by layer.
    fn arranged(&self, image: &WaveletImage, group: &PlaneGroup, texture: usize) -> Vec<u8> {
        let bytes = group.packing.formats()[texture].block_bytes();
        let row = self.size[0] as usize / 4 * bytes;
        let layer_bytes = row * self.size[1] as usize / 4;
        let mut arranged = vec![0; layer_bytes * group.layers()];
        for (layer, out) in arranged.chunks_exact_mut(layer_bytes).enumerate() {
            for level in 0..image.levels {
                let origin = self.origin(level).map(|texel| texel as usize / 4);
                let size = group.texture_level_size(image.size, level);
                let width = size[0].div_ceil(4) as usize * bytes;
                let rows = group.level_blocks(image.size, texture, level, layer);
                for (y, blocks) in rows.chunks_exact(width).enumerate() {
                    let start = (origin[1] + y) * row + origin[0] * bytes;
                    out[start..start + width].copy_from_slice(blocks);
                }
            }
        }
        arranged
    }
}

/// The first level that has no block of its own between `stack - (2 stack >> n)` and the next.
fn tail(stack: u32) -> u32 {
    33 - stack.leading_zeros()
}

// The codec does without Bevy, so its types are reflected here, as values without fields.
impl_reflect_opaque!((in bevy_wavelet_tex::codec::axes) ColorAxes(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::blocks) BlockFormat(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::image) ColorSpace(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::image) Content(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::packing) Packing(Clone, Debug, PartialEq));
impl_reflect_opaque!((in bevy_wavelet_tex::codec::quantizer) PlaneCoding(Clone, Debug, PartialEq));

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::{
        layout::{level_count, texture_level_size},
        packing::Packing,
    };

    #[test]
    fn no_level_lies_on_another_or_outside() {
        let sizes = (1..400u32).chain([512, 1000, 2048, 8192]);
        let packings = Packing::ALL.into_iter().zip([0, 0, 0, 0, 2]);
        let all = sizes.flat_map(|width| packings.clone().map(move |packing| (width, packing)));
        for (width, (packing, subsampling)) in all {
            for height in [1u32, 8, 12, 37, 64, 100, 256, 600, 1024] {
                let size = [width, height];
                let texels = |level| texture_level_size(packing, size, subsampling, level);
                let most = level_count(size);
                for levels in [1, 2, most / 2, most].into_iter().filter(|l| *l > 0) {
                    let atlas = MipAtlas::new(levels, texels);
                    let size_of = |level| texels(level).map(|s: u32| s.next_multiple_of(4));
                    let boxes = (0..levels).map(|level| (atlas.origin(level), size_of(level)));
                    let boxes: Vec<_> = boxes.collect();
                    for (i, (a, a_size)) in boxes.iter().enumerate() {
                        let within = |axis: usize| a[axis] + a_size[axis] <= atlas.size[axis];
                        assert!(
                            within(0) && within(1),
                            "{size:?}, {levels}: {i} in {atlas:?}"
                        );
                        assert!(a.iter().all(|texel| texel % 4 == 0));
                        for (b, b_size) in &boxes[..i] {
                            let apart = |axis: usize| {
                                a[axis] >= b[axis] + b_size[axis]
                                    || b[axis] >= a[axis] + a_size[axis]
                            };
                            assert!(apart(0) || apart(1), "{size:?}, {levels}: {i} in {atlas:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn squares_take_half_as_much_again_as_level_0() {
        let size = |size: [u32; 2]| move |level: u32| size.map(|side: u32| (side >> level).max(1));
        let atlas = MipAtlas::new(9, size([256, 256]));
        assert_eq!(atlas.size, [384, 260]);
        // Strips of levels that are a block high lie below.
        assert_eq!(MipAtlas::new(7, size([256, 4])).size, [256, 8]);
    }
}

//! What the filter has to know of the images of an app, the texture maps of a material, and which of them are filtered
//! together: a part of the key of its pipelines.

use std::collections::HashMap;

use bevy::{
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    mesh::UvChannel,
    prelude::*,
    reflect::{ReflectRef, structs::Struct},
    render::render_resource::{TextureDescriptor, TextureFormat},
};

use super::settings::{EwaExtension, EwaImage, EwaOverrides};
use crate::{
    mips::{
        MipContent, NoMips,
        generator::{MipSupport, is_written_on_gpu},
    },
    report::MipReport,
    settings::EwaMaps,
};

/// An image without its texels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ImageShape {
    size: [u32; 2],
    pub mips: MipReport,
    pub sampler: ImageSamplerDescriptor,
    /// Format of the views that generate levels: an sRGB format where the texels or their view are sRGB.
    pub mip_format: TextureFormat,
    is_excluded: bool,
    /// Whether its sampler is nearest, and the app wants it so.
    is_pixel_art: bool,
    /// Whether its generated levels follow each draw to it.
    pub after_draws: bool,
    descriptor: TextureDescriptor<'static>,
}

impl ImageShape {
    fn new(
        image: &Image,
        choice: EwaImage,
        default_sampler: &ImageSamplerDescriptor,
        support: Option<&MipSupport>,
    ) -> Self {
        let descriptor = &image.texture_descriptor;
        let sampler = match &image.sampler {
            ImageSampler::Default => default_sampler,
            ImageSampler::Descriptor(sampler) => sampler,
        };
        let is_nearest = matches!(sampler.mag_filter, ImageFilterMode::Nearest)
            || matches!(sampler.min_filter, ImageFilterMode::Nearest);
        let is_pixel_art = is_nearest && !choice.use_nearest;
        let is_written = is_written_on_gpu(descriptor);
        let mips = if descriptor.mip_level_count > 1 {
            MipReport::Own(descriptor.mip_level_count)
        } else if choice.is_excluded || choice.max_levels <= 1 {
            MipReport::Without(NoMips::Excluded)
        } else if is_pixel_art {
            MipReport::Without(NoMips::NearestSampler)
        } else if is_written && !choice.after_draws {
            MipReport::Without(NoMips::WrittenOnGpu)
        } else {
            let levels = support.map_or(Err(NoMips::NoRenderer), |support| {
                support.levels(descriptor)
            });
            match levels {
                Ok(levels) => MipReport::Generated(levels.min(choice.max_levels)),
                Err(reason) => MipReport::Without(reason),
            }
        };
        let view = image.texture_view_descriptor.as_ref();
        let view_format = view.and_then(|view| view.format);
        let format = descriptor.format;
        Self {
            size: [descriptor.size.width, descriptor.size.height],
            mips,
            sampler: sampler.clone(),
            mip_format: view_format.filter(|view| view.is_srgb()).unwrap_or(format),
            is_excluded: choice.is_excluded,
            is_pixel_art,
            after_draws: is_written && choice.after_draws,
            descriptor: descriptor.clone(),
        }
    }

    /// Whether texture coordinates beyond the image are clamped.
    fn is_clamped(&self) -> bool {
        use ImageAddressMode::{ClampToBorder, ClampToEdge};
        let modes = [self.sampler.address_mode_u, self.sampler.address_mode_v];
        let mut modes = modes.iter();
        modes.any(|mode| matches!(mode, ClampToEdge | ClampToBorder))
    }

    /// Whether the image is left as it is.
    fn is_left_alone(&self) -> bool {
        self.is_excluded || self.is_pixel_art
    }

    /// The sampler with a higher anisotropy; `None` where it has that already, or filters otherwise than linearly,
    /// which the graphics interfaces forbid with anisotropy.
    pub(super) fn with_anisotropy(&self, clamp: u16) -> Option<ImageSamplerDescriptor> {
        let sampler = &self.sampler;
        let filters = [
            sampler.mag_filter,
            sampler.min_filter,
            sampler.mipmap_filter,
        ];
        let is_linear = filters
            .iter()
            .all(|filter| matches!(filter, ImageFilterMode::Linear));
        let is_raised = is_linear && !self.is_excluded && sampler.anisotropy_clamp < clamp;
        is_raised.then(|| ImageSamplerDescriptor {
            anisotropy_clamp: clamp,
            ..sampler.clone()
        })
    }
}

/// All images of the app.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// The sampler of images without one of their own.
    pub(super) default_sampler: ImageSamplerDescriptor,
    shapes: HashMap<AssetId<Image>, ImageShape>,
}

impl Images {
    pub(super) fn get(&self, id: AssetId<Image>) -> Option<&ImageShape> {
        self.shapes.get(&id)
    }

    /// Looks at an image anew, and returns whether it is another one than before.
    pub(super) fn update(
        &mut self,
        id: AssetId<Image>,
        images: &Assets<Image>,
        overrides: &EwaOverrides,
        support: Option<&MipSupport>,
    ) -> bool {
        let shape = images.get(id).map(|image| {
            ImageShape::new(image, overrides.image(id), &self.default_sampler, support)
        });
        let previous = match shape {
            Some(shape) => self.shapes.insert(id, shape),
            None => self.shapes.remove(&id),
        };
        previous.as_ref() != self.shapes.get(&id)
    }
}

/// The maps that are filtered: the names of the fields `*_texture` of `StandardMaterial` and, in capitals, of the shader
/// defs. The depth map is not among them, which parallax mapping reads at many points.
pub(super) const MAPS: [&str; 14] = [
    "base_color",
    "emissive",
    "normal_map",
    "metallic_roughness",
    "occlusion",
    "specular",
    "specular_tint",
    "clearcoat",
    "clearcoat_roughness",
    "clearcoat_normal",
    "specular_transmission",
    "thickness",
    "diffuse_transmission",
    "anisotropy",
];

/// The number of maps, from the first on, that can share a loop: those that Bevy binds with any features.
const SHARABLE: usize = 5;

const BASE_COLOR: usize = 0;
const NORMAL_MAP: usize = 2;

/// A map of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Map<'a> {
    /// Index in [`MAPS`].
    pub index: usize,
    pub texture: &'a Handle<Image>,
    /// Whether it has the second UV set.
    pub is_uv_b: bool,
}

impl Map<'_> {
    /// Its name in [`MAPS`].
    fn name(&self) -> &'static str {
        MAPS[self.index]
    }

    /// Returns what the map's texels mean in this material.
    pub(super) fn content(&self, material: &StandardMaterial) -> MipContent {
        if self.name().contains("normal") {
            return MipContent::Normals;
        }
        match material.alpha_mode {
            _ if self.index != BASE_COLOR => MipContent::Values,
            AlphaMode::Opaque | AlphaMode::Premultiplied => MipContent::Values,
            // The texture's alpha is multiplied by that of the colour.
            AlphaMode::Mask(cutoff) if material.base_color.alpha() > 0.0 => MipContent::Mask {
                cutoff: cutoff / material.base_color.alpha(),
            },
            _ => MipContent::Transparent,
        }
    }
}

/// The textures of a material of any type.
#[derive(Default)]
pub(super) struct MaterialTextures<'a> {
    /// Bevy's own material, which is the material itself or the base of an extended one.
    pub standard: Option<&'a StandardMaterial>,
    /// The settings of the material itself.
    pub extension: Option<&'a EwaExtension>,
    /// Textures that are not maps of `standard`.
    pub others: Vec<AssetId<Image>>,
}

impl<'a> MaterialTextures<'a> {
    /// Finds the textures of a material, by reflection.
    pub(super) fn of(material: &'a dyn PartialReflect) -> Self {
        let mut textures = Self::default();
        textures.visit(material);
        textures
    }

    fn visit(&mut self, value: &'a dyn PartialReflect) {
        if let Some(standard) = value.try_downcast_ref() {
            self.standard = Some(standard);
        } else if let Some(extension) = value.try_downcast_ref() {
            self.extension = Some(extension);
        } else if let Some(image) = value.try_downcast_ref::<Handle<Image>>() {
            self.others.push(image.id());
        } else {
            match value.reflect_ref() {
                ReflectRef::Struct(value) => value.iter_fields().for_each(|(_, v)| self.visit(v)),
                ReflectRef::TupleStruct(value) => value.iter_fields().for_each(|v| self.visit(v)),
                ReflectRef::Tuple(value) => value.iter_fields().for_each(|v| self.visit(v)),
                ReflectRef::Enum(value) => value.iter_fields().for_each(|v| self.visit(v.value())),
                ReflectRef::List(value) => value.iter().for_each(|v| self.visit(v)),
                ReflectRef::Array(value) => value.iter().for_each(|v| self.visit(v)),
                _ => {}
            }
        }
    }
}

/// Returns the maps that a material has.
///
/// The fields are found by reflection: which of them `StandardMaterial` has depends on Bevy's features
/// `pbr_*_textures`, which a game may or may not enable and a dependency cannot query.
pub(super) fn maps(material: &StandardMaterial) -> impl Iterator<Item = Map<'_>> {
    material.iter_fields().filter_map(|(field, value)| {
        let texture = value.try_downcast_ref::<Option<Handle<Image>>>()?;
        let texture = texture.as_ref()?;
        let name = field.strip_suffix("_texture")?;
        let index = MAPS.iter().position(|map| *map == name)?;
        let channel = material.field(&format!("{name}_channel"))?;
        let is_uv_b = *channel.try_downcast_ref::<UvChannel>()? != UvChannel::Uv0;
        Some(Map {
            index,
            texture,
            is_uv_b,
        })
    })
}

/// How the maps of a material are filtered. Bit n of a mask is map n of `MAPS`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MapLayout {
    /// Mask of the maps of the same size, mip levels and UV set, which one loop filters.
    pub(super) shared: u32,
    /// Mask of the maps that are filtered each on its own.
    pub(super) own: u32,
    /// Whether the shared maps have the second UV set.
    pub(super) is_shared_uv_b: bool,
    /// Whether parallax mapping changes the texture coordinates.
    pub(super) has_parallax: bool,
    /// Whether a sampler clamps. Large texture coordinates are reduced by whole periods, to stay precise, only
    /// where all textures repeat or mirror: they share the shader defs.
    pub(super) is_clamped: bool,
}

impl MapLayout {
    /// The layout of the chosen maps of a material; without any map where the pipelines are Bevy's own.
    pub(super) fn of(material: &StandardMaterial, chosen: EwaMaps, images: &Images) -> Self {
        let mut layout = Self {
            has_parallax: material.depth_map.is_some(),
            ..Self::default()
        };
        let mut groups = Vec::new();
        for map in maps(material) {
            // Of an unlit material, Bevy shows no other map.
            let is_shown = map.index == BASE_COLOR || !material.unlit;
            if !is_shown || !chosen.contains(map.name()) {
                continue;
            }
            let bit = 1 << map.index;
            let Some(image) = images.get(map.texture.id()) else {
                layout.own |= bit;
                continue;
            };
            if image.is_left_alone() {
                continue;
            }
            layout.own |= bit;
            layout.is_clamped |= image.is_clamped();
            if map.index < SHARABLE {
                let shape = (image.size, image.mips.levels(), map.is_uv_b);
                match groups.iter_mut().find(|(other, _)| *other == shape) {
                    Some((_, mask)) => *mask |= bit,
                    None => groups.push((shape, bit)),
                }
            }
        }
        // The first of the largest ones.
        let largest = groups.into_iter().rev();
        let largest = largest.max_by_key(|(_, mask): &(_, u32)| mask.count_ones());
        if let Some(((_, _, is_uv_b), mask)) = largest
            && mask.count_ones() > 1
        {
            layout.shared = mask;
            layout.own &= !mask;
            layout.is_shared_uv_b = is_uv_b;
        }
        layout
    }

    /// The layout of these maps, of the first UV set and repeating, of which those of the first mask share a loop.
    pub const fn of_masks(shared: u32, own: u32) -> Self {
        Self {
            shared,
            own,
            is_shared_uv_b: false,
            has_parallax: false,
            is_clamped: false,
        }
    }

    /// The same layout with or without parallax mapping.
    pub const fn with_parallax(self, has_parallax: bool) -> Self {
        Self {
            has_parallax,
            ..self
        }
    }

    /// Whether the map of this index in [`MAPS`] is filtered.
    pub(super) fn contains(self, index: usize) -> bool {
        (self.shared | self.own) & (1 << index) != 0
    }

    pub(super) fn is_empty(self) -> bool {
        self.shared | self.own == 0
    }

    /// The layout in a prepass or a shadow map, which sample each map on its own, and no others than those of the
    /// base colour's alpha and of normals.
    pub(super) fn in_prepass(self, has_alpha: bool, has_normals: bool) -> Self {
        let mask = u32::from(has_alpha) << BASE_COLOR | u32::from(has_normals) << NORMAL_MAP;
        Self {
            shared: 0,
            has_parallax: false,
            own: (self.shared | self.own) & mask,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::asset::uuid::Uuid;

    use super::*;

    fn handle(n: u128) -> Handle<Image> {
        Handle::from(Uuid::from_u128(n))
    }

    /// Images 1 to 9 of 64 texels, and from 10 on of 32.
    fn images() -> Images {
        let mut sampler = ImageSamplerDescriptor::linear();
        sampler.set_address_mode(ImageAddressMode::Repeat);
        let shapes = (1..20).map(|n| {
            let side = if n < 10 { 64 } else { 32 };
            (id(n), shape(side, sampler.clone()))
        });
        Images {
            shapes: shapes.collect(),
            ..default()
        }
    }

    fn id(n: u128) -> AssetId<Image> {
        AssetId::from(Uuid::from_u128(n))
    }

    fn material() -> StandardMaterial {
        StandardMaterial {
            base_color_texture: Some(handle(1)),
            emissive_texture: Some(handle(2)),
            normal_map_texture: Some(handle(3)),
            occlusion_texture: Some(handle(4)),
            ..StandardMaterial::default()
        }
    }

    fn masks(material: &StandardMaterial, chosen: EwaMaps) -> (u32, u32) {
        let layout = MapLayout::of(material, chosen, &images());
        (layout.shared, layout.own)
    }

    #[test]
    fn chosen_maps_of_one_size_share_a_loop() {
        assert_eq!(masks(&material(), EwaMaps::default()), (0b111, 0));
        assert_eq!(masks(&material(), EwaMaps::ALL), (0b10111, 0));
        assert_eq!(masks(&material(), EwaMaps::NONE), (0, 0));
        let no_maps = StandardMaterial::default();
        assert_eq!(masks(&no_maps, EwaMaps::ALL), (0, 0), "no maps");
    }

    #[test]
    fn a_map_of_another_size_or_uv_set_or_one_that_is_alone_has_a_loop_of_its_own() {
        type Change = fn(&mut StandardMaterial);
        let changes: [(Change, EwaMaps, (u32, u32)); 4] = [
            // A smaller one.
            (
                |material| material.normal_map_texture = Some(handle(10)),
                EwaMaps::default(),
                (0b11, 0b100),
            ),
            (
                |material| material.emissive_channel = UvChannel::Uv1,
                EwaMaps::default(),
                (0b101, 0b10),
            ),
            (
                |material| (material.emissive_texture, material.normal_map_texture) = (None, None),
                EwaMaps::default(),
                (0, 1),
            ),
            (|material| material.unlit = true, EwaMaps::ALL, (0, 1)),
        ];
        for (change, chosen, expected) in changes {
            let mut material = material();
            change(&mut material);
            assert_eq!(masks(&material, chosen), expected, "{material:?}");
        }
    }

    #[test]
    fn the_second_uv_set_can_be_the_shared_one() {
        let second_set = StandardMaterial {
            base_color_channel: UvChannel::Uv1,
            normal_map_channel: UvChannel::Uv1,
            ..material()
        };
        let layout = MapLayout::of(&second_set, EwaMaps::default(), &images());
        assert_eq!((layout.shared, layout.own), (0b101, 0b10));
        assert!(layout.is_shared_uv_b);
    }

    #[test]
    fn a_prepass_has_the_alpha_and_the_normals_only() {
        let layout = MapLayout::of_masks(0b111, 1 << 9);
        let masks = |alpha, normals| layout.in_prepass(alpha, normals).own;
        assert_eq!(masks(true, true), 0b101);
        assert_eq!(masks(false, true), 0b100);
        assert!(layout.in_prepass(false, false).is_empty());
    }

    #[test]
    fn all_maps_but_parallax_are_found_with_their_coordinates() {
        let mut material = StandardMaterial {
            base_color_texture: Some(handle(1)),
            emissive_texture: Some(handle(2)),
            emissive_channel: UvChannel::Uv1,
            normal_map_texture: Some(handle(3)),
            depth_map: Some(handle(4)),
            ..default()
        };
        let mut actual: Vec<_> = maps(&material)
            .map(|map| {
                let has_normals = map.content(&material) == MipContent::Normals;
                (map.name(), map.texture.id(), map.is_uv_b, has_normals)
            })
            .collect();
        actual.sort_by_key(|(name, ..)| *name);
        let expected = [
            ("base_color", 1, false, false),
            ("emissive", 2, true, false),
            ("normal_map", 3, false, true),
        ];
        assert_eq!(
            actual,
            expected.map(|(name, n, is_uv_b, normals)| (name, id(n), is_uv_b, normals))
        );
        material.base_color_texture = None;
        assert_eq!(maps(&material).count(), 2);
    }

    #[test]
    fn the_alpha_mode_decides_what_a_base_colour_is() {
        let mask = |cutoff| MipContent::Mask { cutoff };
        for (alpha_mode, alpha, expected) in [
            (AlphaMode::Opaque, 1.0, MipContent::Values),
            (AlphaMode::Premultiplied, 1.0, MipContent::Values),
            (AlphaMode::Blend, 1.0, MipContent::Transparent),
            (AlphaMode::Mask(0.25), 1.0, mask(0.25)),
            (AlphaMode::Mask(0.25), 0.5, mask(0.5)),
            (AlphaMode::Mask(0.25), 0.0, MipContent::Transparent),
        ] {
            let material = StandardMaterial {
                base_color: Color::WHITE.with_alpha(alpha),
                base_color_texture: Some(handle(1)),
                alpha_mode,
                ..default()
            };
            let map = maps(&material).next().expect("a map");
            assert_eq!(map.content(&material), expected, "{alpha_mode:?} {alpha}");
        }
    }

    #[test]
    fn textures_of_any_material_are_found() {
        #[derive(Reflect)]
        struct Game {
            base: StandardMaterial,
            detail: Option<Handle<Image>>,
            layers: Vec<(Handle<Image>, f32)>,
            none: Option<Handle<Image>>,
        }
        let material = Game {
            base: default(),
            detail: Some(handle(1)),
            layers: vec![(handle(2), 1.0), (handle(3), 0.5)],
            none: None,
        };
        let textures = MaterialTextures::of(&material);
        assert!(textures.standard.is_some() && textures.extension.is_none());
        assert_eq!(textures.others, [1, 2, 3].map(id));
    }

    /// An image of this size with a sampler.
    fn shape(size: u32, sampler: ImageSamplerDescriptor) -> ImageShape {
        let mut image = Image::default();
        image.texture_descriptor.size.width = size;
        image.texture_descriptor.size.height = size;
        image.sampler = ImageSampler::Descriptor(sampler);
        ImageShape::new(&image, EwaImage::default(), &default(), None)
    }

    #[test]
    fn only_linear_samplers_get_anisotropy_and_never_less_than_they_have() {
        let raised = |sampler, clamp| {
            let sampler = shape(4, sampler).with_anisotropy(clamp);
            sampler.map(|sampler| sampler.anisotropy_clamp)
        };
        assert_eq!(raised(ImageSamplerDescriptor::linear(), 16), Some(16));
        assert_eq!(raised(ImageSamplerDescriptor::linear(), 1), None);
        assert_eq!(raised(ImageSamplerDescriptor::nearest(), 16), None);
        let has_more = ImageSamplerDescriptor {
            anisotropy_clamp: 8,
            ..ImageSamplerDescriptor::linear()
        };
        assert_eq!(raised(has_more, 4), None);
    }

    #[test]
    fn what_a_game_draws_or_shows_as_pixel_art_is_left_alone() {
        let of = |image: &Image, choice| {
            ImageShape::new(image, choice, &ImageSamplerDescriptor::linear(), None).mips
        };
        let target = Image::new_target_texture(64, 64, TextureFormat::Rgba8UnormSrgb, None);
        let asked = EwaImage {
            after_draws: true,
            ..default()
        };
        let without = MipReport::Without;
        assert_eq!(of(&target, default()), without(NoMips::WrittenOnGpu));
        assert_eq!(of(&target, asked), without(NoMips::NoRenderer));
        let mut image = Image::default();
        assert_eq!(of(&image, EwaImage::EXCLUDED), without(NoMips::Excluded));
        image.sampler = ImageSampler::nearest();
        assert_eq!(of(&image, default()), without(NoMips::NearestSampler));
        image.texture_descriptor.mip_level_count = 3;
        assert_eq!(of(&image, default()), MipReport::Own(3));
    }
}

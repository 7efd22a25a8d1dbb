//! The texture maps of a material.

use bevy::{
    mesh::UvChannel,
    prelude::*,
    reflect::{ReflectRef, structs::Struct},
};

use super::extension::EwaExtension;
use crate::mips::MipContent;

/// The maps that are filtered: the names of the fields `*_texture` of `StandardMaterial` and, in capitals, of the shader
/// defs. The depth map is not among them, since parallax mapping marches through it.
pub(crate) const MAPS: [&str; 14] = [
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
pub(crate) const SHARABLE: usize = 5;

/// Index of the map of the base colour.
pub(crate) const BASE_COLOR: usize = 0;
/// Index of the map of normals.
pub(crate) const NORMAL_MAP: usize = 2;

/// A map of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Map<'a> {
    /// Index in [`MAPS`].
    pub index: usize,
    /// The texture.
    pub texture: &'a Handle<Image>,
    /// Whether it has the second UV set.
    pub is_uv_b: bool,
}

impl Map<'_> {
    /// Its name in [`MAPS`].
    pub(crate) fn name(&self) -> &'static str {
        MAPS[self.index]
    }

    /// What its texels mean in this material.
    pub(crate) fn content(&self, material: &StandardMaterial) -> MipContent {
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

/// What a material of any type shows.
#[derive(Default)]
pub(crate) struct Shown<'a> {
    /// Bevy's own material, which is the material itself or the base of an extended one.
    pub standard: Option<&'a StandardMaterial>,
    /// The settings of the material itself.
    pub extension: Option<&'a EwaExtension>,
    /// Textures that are not maps of `standard`.
    pub others: Vec<AssetId<Image>>,
}

impl<'a> Shown<'a> {
    /// Finds what a material shows, by reflection.
    pub(crate) fn by(material: &'a dyn PartialReflect) -> Self {
        let mut shown = Self::default();
        shown.visit(material);
        shown
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
pub(crate) fn maps(material: &StandardMaterial) -> impl Iterator<Item = Map<'_>> {
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

#[cfg(test)]
mod tests {
    use bevy::asset::uuid::Uuid;

    use super::*;

    #[test]
    fn all_maps_but_parallax_are_found_with_their_coordinates() {
        let handle = |n| Some(Handle::from(Uuid::from_u128(n)));
        let mut material = StandardMaterial {
            base_color_texture: handle(1),
            emissive_texture: handle(2),
            emissive_channel: UvChannel::Uv1,
            normal_map_texture: handle(3),
            depth_map: handle(4),
            ..default()
        };
        let mut found: Vec<_> = maps(&material)
            .map(|map| {
                let has_normals = map.content(&material) == MipContent::Normals;
                (map.name(), map.texture.id(), map.is_uv_b, has_normals)
            })
            .collect();
        found.sort_by_key(|(name, ..)| *name);
        let expected = [
            ("base_color", 1, false, false),
            ("emissive", 2, true, false),
            ("normal_map", 3, false, true),
        ];
        let id = |n| AssetId::from(Uuid::from_u128(n));
        assert_eq!(
            found,
            expected.map(|(name, n, is_uv_b, normals)| (name, id(n), is_uv_b, normals))
        );
        material.base_color_texture = None;
        assert_eq!(maps(&material).count(), 2);
    }

    #[test]
    fn the_alpha_mode_decides_what_a_base_colour_is() {
        let content = |alpha_mode, alpha| {
            let material = StandardMaterial {
                base_color: Color::WHITE.with_alpha(alpha),
                base_color_texture: Some(Handle::from(Uuid::from_u128(1))),
                alpha_mode,
                ..default()
            };
            let map = maps(&material).next().expect("a map");
            map.content(&material)
        };
        assert_eq!(content(AlphaMode::Opaque, 1.0), MipContent::Values);
        assert_eq!(content(AlphaMode::Premultiplied, 1.0), MipContent::Values);
        assert_eq!(content(AlphaMode::Blend, 1.0), MipContent::Transparent);
        let mask = |cutoff| MipContent::Mask { cutoff };
        assert_eq!(content(AlphaMode::Mask(0.25), 1.0), mask(0.25));
        assert_eq!(content(AlphaMode::Mask(0.25), 0.5), mask(0.5));
        assert_eq!(content(AlphaMode::Mask(0.25), 0.0), MipContent::Transparent);
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
        let handle = |n| Handle::<Image>::from(Uuid::from_u128(n));
        let material = Game {
            base: default(),
            detail: Some(handle(1)),
            layers: vec![(handle(2), 1.0), (handle(3), 0.5)],
            none: None,
        };
        let shown = Shown::by(&material);
        assert!(shown.standard.is_some() && shown.extension.is_none());
        assert_eq!(shown.others, [1, 2, 3].map(|n| handle(n).id()));
    }
}

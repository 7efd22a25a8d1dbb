//! The texture maps of a material.

use bevy::{mesh::UvChannel, prelude::*, reflect::structs::Struct};

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

    /// Whether it holds normals.
    pub(crate) fn has_normals(&self) -> bool {
        self.name().contains("normal")
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
            .map(|map| (map.name(), map.texture.id(), map.is_uv_b, map.has_normals()))
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
}

//! The texture maps of a material.

use bevy::{prelude::*, reflect::structs::Struct};

/// The only map that is not filtered: parallax mapping marches through it.
const PARALLAX: &str = "depth_map";

/// Returns the maps that are filtered, and whether they hold normals.
///
/// The fields are found by reflection: which of them `StandardMaterial` has depends on Bevy's features
/// `pbr_*_textures`, which a game may or may not enable and a dependency cannot query.
pub(crate) fn maps(material: &StandardMaterial) -> impl Iterator<Item = (&Handle<Image>, bool)> {
    material.iter_fields().filter_map(|(name, value)| {
        let map = value
            .try_downcast_ref::<Option<Handle<Image>>>()?
            .as_ref()?;
        (name != PARALLAX).then(|| (map, name.contains("normal")))
    })
}

#[cfg(test)]
mod tests {
    use bevy::asset::uuid::Uuid;

    use super::*;

    #[test]
    fn all_maps_but_parallax_are_found_and_normals_known() {
        let handle = |n| Some(Handle::from(Uuid::from_u128(n)));
        let mut material = StandardMaterial {
            base_color_texture: handle(1),
            emissive_texture: handle(2),
            normal_map_texture: handle(3),
            depth_map: handle(4),
            ..default()
        };
        let mut found: Vec<_> = maps(&material)
            .map(|(map, normals)| (map.clone(), normals))
            .collect();
        found.sort_by_key(|(map, _)| map.id());
        let expected = [(1, false), (2, false), (3, true)];
        assert_eq!(
            found,
            expected.map(|(n, normals)| (Handle::from(Uuid::from_u128(n)), normals))
        );
        material.base_color_texture = None;
        assert_eq!(maps(&material).count(), 2);
    }
}

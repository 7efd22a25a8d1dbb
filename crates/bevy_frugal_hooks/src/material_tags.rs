//! Tags, by which an app selects the materials that a hook changes.

use std::{
    any::TypeId,
    collections::{BTreeMap, HashMap},
};

use bevy::{asset::UntypedAssetId, prelude::*};

/// Tags of all materials of a type, or of single materials: names with a number that a hook interprets.
/// It is a resource of the render world.
///
/// A material gets the tags that exist when Bevy prepares it, and keeps them until its asset changes.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct MaterialTags {
    types: HashMap<TypeId, BTreeMap<&'static str, u64>>,
    materials: HashMap<UntypedAssetId, BTreeMap<&'static str, u64>>,
}

impl MaterialTags {
    /// Sets a tag of all materials of a type, or removes it if `value` is `None`.
    pub fn set_for_type(&mut self, material_type: TypeId, name: &'static str, value: Option<u64>) {
        let tags = self.types.entry(material_type).or_default();
        match value {
            Some(value) => tags.insert(name, value),
            None => tags.remove(name),
        };
    }

    /// Sets a tag of one material, which overrides its type's tag of the same name, or removes it if
    /// `value` is `None`.
    pub fn set_for_material(
        &mut self,
        material: UntypedAssetId,
        name: &'static str,
        value: Option<u64>,
    ) {
        if let Some(value) = value {
            let tags = self.materials.entry(material).or_default();
            tags.insert(name, value);
        } else if let Some(tags) = self.materials.get_mut(&material) {
            tags.remove(name);
            if tags.is_empty() {
                self.materials.remove(&material);
            }
        }
    }

    pub(crate) fn of(&self, material: UntypedAssetId) -> Vec<(&'static str, u64)> {
        let of_type = self.types.get(&material.type_id()).into_iter().flatten();
        let single = self.materials.get(&material).into_iter().flatten();
        let tags: BTreeMap<_, _> = of_type.chain(single).collect();
        tags.into_iter()
            .map(|(name, value)| (*name, *value))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_material_has_its_own_tags_and_those_of_its_type() {
        let id = |n| {
            UntypedAssetId::from(AssetId::<Image>::Uuid {
                uuid: bevy::asset::uuid::Uuid::from_u128(n),
            })
        };
        let of_type = TypeId::of::<Image>();
        let mut tags = MaterialTags::default();
        tags.set_for_type(of_type, "a", Some(1));
        tags.set_for_material(id(1), "b", Some(2));
        tags.set_for_material(id(1), "a", Some(3));
        assert_eq!(tags.of(id(1)), [("a", 3), ("b", 2)]);
        assert_eq!(tags.of(id(2)), [("a", 1)]);
        tags.set_for_material(id(1), "a", None);
        tags.set_for_material(id(1), "b", None);
        assert_eq!(tags.of(id(1)), [("a", 1)]);
        tags.set_for_type(of_type, "a", None);
        assert_eq!(tags.of(id(1)), []);
    }
}

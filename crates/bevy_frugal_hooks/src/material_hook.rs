//! Hooks at the end of the specialization of every material's pipeline, and the tags by which a hook recognizes
//! the materials that it changes.
//!
//! Bevy calls `MaterialProperties::user_specialize` as the last step of a material's pipeline
//! specialization (`Material::specialize` runs there). [`MaterialHookPlugin`] replaces it by one
//! function that calls the original and then every [`MaterialHook`], so that plugins do not displace
//! one another.
//!
//! The replaced field is a plain function pointer, without access to any world. The hooks are
//! therefore global to the process and must decide from the key and the descriptor alone whether to
//! change a pipeline. An app selects materials, by type or individually, with [`MaterialTags`], which
//! become a part of the key.

use std::{
    any::{Any, TypeId},
    collections::{BTreeMap, HashMap},
    ptr::fn_addr_eq,
    sync::{Arc, PoisonError, RwLock},
};

use bevy::{
    asset::UntypedAssetId,
    material::{
        key::{ErasedMaterialKey, ErasedMaterialPipelineKey},
        specialize::{SpecializedMeshPipelineError, UserSpecializeFn},
    },
    mesh::MeshVertexBufferLayoutRef,
    pbr::{MeshPipelineKey, PreparedMaterial},
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems, erased_render_asset::ErasedRenderAssets,
        render_resource::RenderPipelineDescriptor,
    },
};

/// The material whose pipeline a hook may change.
#[derive(Clone, Copy, Debug)]
pub struct SpecializedMaterial<'a> {
    /// Flags of the view, the mesh and the material.
    pub mesh_key: MeshPipelineKey,
    /// Type of the material.
    pub material_type: TypeId,
    tags: &'a [(&'static str, u64)],
}

impl SpecializedMaterial<'_> {
    /// Returns the value of the material's tag of this name in the app that builds the pipeline.
    pub fn tag(&self, name: &str) -> Option<u64> {
        let mut tags = self.tags.iter();
        tags.find_map(|(tag, value)| (*tag == name).then_some(*value))
    }
}

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

/// The key of a tagged material, which wraps the material's own key.
#[derive(Clone, PartialEq, Eq, Hash)]
struct TaggedKey {
    material_key: ErasedMaterialKey,
    tags: Vec<(&'static str, u64)>,
}

/// A function that changes a material's pipeline after Bevy and the material itself have specialized it.
pub type MaterialHook = fn(SpecializedMaterial<'_>, &mut RenderPipelineDescriptor);

/// Plugin that calls a hook for the pipelines of all materials. Add one plugin for each hook; a hook
/// that is added twice is called once.
#[derive(Clone, Copy, Debug)]
pub struct MaterialHookPlugin(pub MaterialHook);

impl Plugin for MaterialHookPlugin {
    fn build(&self, app: &mut App) {
        let mut hooks = HOOKS.write().unwrap_or_else(PoisonError::into_inner);
        if !hooks.iter().any(|&hook| fn_addr_eq(hook, self.0)) {
            hooks.push(self.0);
        }
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        if !render_app.world().contains_resource::<HooksInstalled>() {
            render_app
                .insert_resource(HooksInstalled)
                .init_resource::<MaterialTags>()
                .add_systems(
                    Render,
                    wrap_materials
                        .after(RenderSystems::PrepareAssets)
                        .before(RenderSystems::Specialize),
                );
        }
    }

    fn is_unique(&self) -> bool {
        false
    }
}

#[derive(Resource)]
struct HooksInstalled;

static HOOKS: RwLock<Vec<MaterialHook>> = RwLock::new(Vec::new());

/// The original `user_specialize` function of each material type.
static ORIGINALS: RwLock<BTreeMap<TypeId, UserSpecializeFn>> = RwLock::new(BTreeMap::new());

/// Replaces each material's `user_specialize` by [`specialize`], which calls the original.
///
/// It checks all materials whenever one of them changed, because Bevy prepares a changed material anew.
fn wrap_materials(
    mut materials: ResMut<ErasedRenderAssets<PreparedMaterial>>,
    tags: Res<MaterialTags>,
) {
    if !materials.is_changed() {
        return;
    }
    let mut originals = ORIGINALS.write().unwrap_or_else(PoisonError::into_inner);
    for (id, material) in materials.bypass_change_detection().iter_mut() {
        let current = material.properties.user_specialize;
        let known = originals.get(&id.type_id()).copied();
        if is_replacement(current) || (known.is_some() && !is_same(current, known)) {
            // Already replaced, or another plugin wrapped the replacement and will call it.
            continue;
        }
        // The material was prepared in this frame, so there are no other references to it yet.
        let Some(properties) = Arc::get_mut(&mut material.properties) else {
            warn_once!(
                "the material {id:?} is already in use and keeps its pipeline: change the asset to have \
                 it prepared again"
            );
            continue;
        };
        let tags = tags.of(id);
        if tags.is_empty() {
            properties.user_specialize = Some(specialize);
        } else {
            let material_key = std::mem::take(&mut properties.material_key);
            properties.material_key = ErasedMaterialKey::new(TaggedKey { material_key, tags });
            properties.user_specialize = Some(specialize_tagged);
        }
        if let Some(original) = current {
            originals.insert(id.type_id(), original);
        }
    }
}

fn is_replacement(current: Option<UserSpecializeFn>) -> bool {
    is_same(current, Some(specialize)) || is_same(current, Some(specialize_tagged))
}

fn is_same(a: Option<UserSpecializeFn>, b: Option<UserSpecializeFn>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => fn_addr_eq(a, b),
        (None, None) => true,
        _ => false,
    }
}

/// Replacement of `user_specialize` for materials without tags.
fn specialize(
    pipeline: &dyn Any,
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
    key: ErasedMaterialPipelineKey,
) -> Result<(), SpecializedMeshPipelineError> {
    specialize_with(pipeline, descriptor, layout, key, &[])
}

/// Replacement of `user_specialize` for materials whose key is a [`TaggedKey`].
fn specialize_tagged(
    pipeline: &dyn Any,
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
    key: ErasedMaterialPipelineKey,
) -> Result<(), SpecializedMeshPipelineError> {
    let tagged: TaggedKey = key.material_key.to_key();
    let key = ErasedMaterialPipelineKey {
        material_key: tagged.material_key,
        ..key
    };
    specialize_with(pipeline, descriptor, layout, key, &tagged.tags)
}

fn specialize_with(
    pipeline: &dyn Any,
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
    key: ErasedMaterialPipelineKey,
    tags: &[(&'static str, u64)],
) -> Result<(), SpecializedMeshPipelineError> {
    let material = SpecializedMaterial {
        mesh_key: key.mesh_key.downcast(),
        material_type: key.type_id,
        tags,
    };
    // The functions are copied, so that no lock is held while other code runs.
    let originals = || ORIGINALS.read().unwrap_or_else(PoisonError::into_inner);
    let original = originals().get(&key.type_id).copied();
    if let Some(original) = original {
        original(pipeline, descriptor, layout, key)?;
    }
    let hooks = HOOKS.read().unwrap_or_else(PoisonError::into_inner).clone();
    for hook in hooks {
        hook(material, descriptor);
    }
    Ok(())
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

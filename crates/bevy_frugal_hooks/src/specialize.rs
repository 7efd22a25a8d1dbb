//! A last word on the pipeline of every material.
//!
//! Bevy calls `MaterialProperties::user_specialize` at the end of building a material's pipeline
//! (that is where `Material::specialize` runs). [`MaterialHookPlugin`] puts one function in its
//! place that calls what it found and then every [`MaterialHook`], so that plugins do not displace
//! one another.
//!
//! The replaced field is a plain function pointer, without access to any world. The hooks are
//! therefore global to the process and must decide from the key and the descriptor alone whether
//! they are meant.

use std::{
    any::{Any, TypeId},
    collections::HashMap,
    ptr::fn_addr_eq,
    sync::{Arc, PoisonError, RwLock},
};

use bevy::{
    material::{
        key::ErasedMaterialPipelineKey,
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

/// The pipeline that a hook is asked about.
#[derive(Clone, Copy, Debug)]
pub struct SpecializedMaterial {
    /// View, mesh and material flags.
    pub mesh_key: MeshPipelineKey,
    /// The type of the material.
    pub material_type: TypeId,
}

/// Changes a material's pipeline, after Bevy and the material itself did.
pub type MaterialHook = fn(SpecializedMaterial, &mut RenderPipelineDescriptor);

/// Calls a hook for the pipelines of all materials; add one for each hook.
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
            render_app.insert_resource(HooksInstalled).add_systems(
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

/// `Material::specialize` of each type of material.
static ORIGINALS: RwLock<Option<HashMap<TypeId, UserSpecializeFn>>> = RwLock::new(None);

/// Puts [`specialize`] in the place of each material's own function, which it calls.
///
/// Runs over all materials whenever one of them changed: a change makes Bevy prepare a new one.
fn wrap_materials(mut materials: ResMut<ErasedRenderAssets<PreparedMaterial>>) {
    if !materials.is_changed() {
        return;
    }
    let mut originals = ORIGINALS.write().unwrap_or_else(PoisonError::into_inner);
    let originals = originals.get_or_insert_default();
    for (id, material) in materials.bypass_change_detection().iter_mut() {
        let current = material.properties.user_specialize;
        let known = originals.get(&id.type_id()).copied();
        if is_same(current, Some(specialize)) || (known.is_some() && !is_same(current, known)) {
            // Ours already, or somebody wrapped ours and will call it.
            continue;
        }
        // Prepared in this frame, so nobody else holds it yet.
        let Some(properties) = Arc::get_mut(&mut material.properties) else {
            warn_once!("a material is in use already and keeps its pipeline: {id:?}");
            continue;
        };
        properties.user_specialize = Some(specialize);
        if let Some(original) = current {
            originals.insert(id.type_id(), original);
        }
    }
}

fn is_same(a: Option<UserSpecializeFn>, b: Option<UserSpecializeFn>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => fn_addr_eq(a, b),
        (None, None) => true,
        _ => false,
    }
}

fn specialize(
    pipeline: &dyn Any,
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
    key: ErasedMaterialPipelineKey,
) -> Result<(), SpecializedMeshPipelineError> {
    let material = SpecializedMaterial {
        mesh_key: key.mesh_key.downcast(),
        material_type: key.type_id,
    };
    // Copied out, so that no lock is held while foreign code runs.
    let original = {
        let originals = ORIGINALS.read().unwrap_or_else(PoisonError::into_inner);
        originals
            .as_ref()
            .and_then(|originals| originals.get(&key.type_id).copied())
    };
    if let Some(original) = original {
        original(pipeline, descriptor, layout, key)?;
    }
    let hooks = HOOKS.read().unwrap_or_else(PoisonError::into_inner).clone();
    for hook in hooks {
        hook(material, descriptor);
    }
    Ok(())
}

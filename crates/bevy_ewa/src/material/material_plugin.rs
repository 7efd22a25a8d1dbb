//! The plugin of a type of material, and the systems for it.

use std::{any::TypeId, hash::Hash, marker::PhantomData};

use bevy::{
    asset::UntypedAssetId,
    pbr::{Material, MeshMaterial3d},
    prelude::*,
    render::{Render, RenderApp, erased_render_asset::prepare_erased_assets},
};

use super::{
    filtered::{FilteredMaterials, FindSystems},
    settings::{AllMaterials, EwaOverrides},
};

/// The order of the systems that prepare textures and Bevy's, which prepare materials.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PrepareSystems {
    BeforeMaterials,
    AfterMaterials,
}

/// Filters the textures of another type of material, which derives `Reflect`: one line for each type of the game,
/// beside its own `MaterialPlugin`.
///
/// - An `ExtendedMaterial` with a `StandardMaterial` as its base is filtered as that is, where the extension calls
///   Bevy's functions for the base's maps. Textures of the extension are as those of other materials:
/// - Textures of other materials get mip levels and anisotropy, whatever the method, as the plugin cannot change their
///   shaders. Their texels are averaged as [`MipContent::Values`](crate::mips::MipContent::Values).
///
/// [`EwaPlugin`](crate::EwaPlugin) adds those of `StandardMaterial` and of
/// [`EwaStandardMaterial`](crate::EwaStandardMaterial). The settings are those of
/// [`AllMaterials`].
pub struct EwaMaterialPlugin<M>(PhantomData<fn() -> M>);

impl<M> Default for EwaMaterialPlugin<M> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<M> Plugin for EwaMaterialPlugin<M>
where
    M: Material + Reflect,
    M::Data: PartialEq + Eq + Hash + Clone,
{
    fn build(&self, app: &mut App) {
        app.add_systems(
            PostUpdate,
            (
                find_materials::<M>.in_set(FindSystems::Materials),
                mark_materials::<M>.in_set(FindSystems::MarkMaterials),
            )
                .run_if(resource_exists::<Assets<M>>),
        );
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            let prepare = prepare_erased_assets::<MeshMaterial3d<M>>;
            render_app.configure_sets(
                Render,
                (
                    PrepareSystems::BeforeMaterials.before(prepare),
                    PrepareSystems::AfterMaterials.after(prepare),
                ),
            );
        }
    }
}

/// Looks at the materials that have changed, or whose images or settings have.
fn find_materials<M: Material + Reflect>(
    mut filtered: ResMut<FilteredMaterials>,
    all: Res<AllMaterials>,
    overrides: Res<EwaOverrides>,
    materials: Res<Assets<M>>,
    mut events: MessageReader<AssetEvent<M>>,
) {
    let filtered = &mut *filtered;
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                filtered.changes.prepared.insert((*id).into());
                filtered.update(*id, &materials, &all, &overrides);
            }
            AssetEvent::Removed { id } => {
                filtered.update(*id, &materials, &all, &overrides);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    let stale: Vec<AssetId<M>> = if filtered.changes.are_all_materials_stale {
        materials.ids().collect()
    } else {
        let users = filtered.changes.images.keys();
        let users = users.flat_map(|image| filtered.users.get(image).into_iter().flatten());
        let stale = users.chain(&filtered.changes.overridden);
        let of_this_type = stale.filter(|id| id.type_id() == TypeId::of::<M>());
        of_this_type.map(|id| id.typed_unchecked()).collect()
    };
    for id in stale {
        let is_changed = filtered.update(id, &materials, &all, &overrides);
        let id = UntypedAssetId::from(id);
        if is_changed && !filtered.is_awaiting(id) {
            filtered.changes.stale.insert(id);
        }
    }
}

/// Marks materials as modified, so that the renderer prepares them again.
fn mark_materials<M: Material>(filtered: Res<FilteredMaterials>, mut materials: ResMut<Assets<M>>) {
    let changes = &filtered.changes;
    for id in changes.stale.difference(&changes.prepared) {
        if id.type_id() == TypeId::of::<M>()
            && let Some(mut material) = materials.get_mut(id.typed_unchecked::<M>())
        {
            // Only a mutable reference marks the asset as modified.
            let _: &mut M = &mut material;
        }
    }
}

//! Keeps the material table in sync as materials and meshes change.

use std::any::TypeId;

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    platform::collections::HashSet,
    prelude::*,
};
use bevy_frugal_hooks::MaterialImages;

use super::{
    changed_rows::{MovedMeshes, for_each_changed_row, split},
    material_table::{MaterialIndex, MaterialTable, Variant},
    voxel_material::{AsVoxelMaterial, VoxelMaterial},
};
use crate::settings::MeshVoxelMaterial;

/// State of the table's updates for one type of material.
pub(crate) struct MaterialUpdates<M: Asset> {
    /// Entities whose table index is not known yet.
    entities: HashSet<Entity>,
    waiting: HashSet<AssetId<M>>,
    /// The session of the table for which this is.
    session: u64,
}

impl<M: Asset> Default for MaterialUpdates<M> {
    fn default() -> Self {
        Self {
            entities: HashSet::default(),
            waiting: HashSet::default(),
            session: 0,
        }
    }
}

/// Keeps the table and the indices of meshes in sync with the materials of one type.
pub(crate) fn update_materials<M: AsVoxelMaterial>(
    mut commands: Commands,
    columns: Query<
        (
            Entity,
            Ref<MeshMaterial3d<M>>,
            Option<Ref<MeshVoxelMaterial>>,
        ),
        With<Mesh3d>,
    >,
    all: Query<
        (
            Entity,
            &MeshMaterial3d<M>,
            Option<&MeshVoxelMaterial>,
            Option<&MaterialIndex>,
        ),
        With<Mesh3d>,
    >,
    (moved, indices): (Res<MovedMeshes>, Query<&MaterialIndex>),
    mut material_events: MessageReader<AssetEvent<M>>,
    (materials, images): (Res<Assets<M>>, Res<MaterialImages>),
    mut table: ResMut<MaterialTable>,
    mut pending: Local<MaterialUpdates<M>>,
) {
    let is_new_session = pending.session != table.session;
    if is_new_session {
        *pending = MaterialUpdates {
            session: table.session,
            ..default()
        };
    }
    let MaterialUpdates {
        entities,
        waiting,
        session: _,
    } = &mut *pending;
    let this = Some(TypeId::of::<M>());
    let tables = columns.contiguous_iter();
    if is_new_session || tables.is_err() {
        entities.extend(all.iter().map(|(entity, ..)| entity));
    }
    for (rows, handles, own) in tables.into_iter().flatten() {
        let columns = [split(handles).1, own.and_then(|own| split(own).1)];
        for_each_changed_row(&columns, rows.len(), |row| {
            entities.insert(rows[row]);
        });
    }
    for &entity in &moved.entities {
        if all.contains(entity) {
            entities.insert(entity);
        } else if indices
            .get(entity)
            .is_ok_and(|index| index.material_type == this)
        {
            forget_index::<MeshMaterial3d<M>>(&mut commands, entity, this);
        }
    }
    for entity in entities.drain() {
        let Ok((_, material, override_, known)) = all.get(entity) else {
            continue;
        };
        let variant = override_.map_or(Variant::Plain, |mesh| Variant::Overridden(*mesh));
        let id = material.id().untyped();
        if !table.contains(id) || is_new_session {
            waiting.insert(material.id());
        }
        let index = MaterialIndex {
            index: table.index_of(id, variant),
            material_type: this,
        };
        if known != Some(&index) {
            commands.entity(entity).insert(index);
        }
    }
    for event in material_events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id }
                if table.contains(id.untyped()) =>
            {
                waiting.insert(*id);
            }
            AssetEvent::Removed { id } if table.contains(id.untyped()) => {
                table.set(id.untyped(), VoxelMaterial::NEUTRAL);
                waiting.insert(*id);
            }
            _ => {}
        }
    }
    waiting.retain(|&id| {
        if !table.contains(id.untyped()) {
            return false;
        }
        let Some(material) = materials.get(id) else {
            return true;
        };
        let voxel_material = match images.0.get(&id.untyped()) {
            Some(images) => material.as_voxel_material().with_images(images),
            None => material.as_voxel_material(),
        };
        table.set(id.untyped(), voxel_material);
        false
    });
}

/// Resets the index of a mesh that has lost the component that gave it.
fn forget_index<C: Component>(
    commands: &mut Commands,
    entity: Entity,
    material_type: Option<TypeId>,
) {
    commands
        .entity(entity)
        .queue_silenced(move |mut entity: EntityWorldMut| {
            // By now it may have another type of material, whose index it must keep.
            let index = entity.get::<MaterialIndex>();
            let is_of_this = index.is_some_and(|index| index.material_type == material_type);
            if is_of_this && !entity.contains::<C>() {
                entity.insert(MaterialIndex::default());
            }
        });
}

/// A material id that no asset has; all of these meshes share it in the table.
fn unknown() -> UntypedAssetId {
    const UNKNOWN: Uuid = Uuid::from_u128(0x9f0b_5a4e_31c6_4d7b_8a52_77e1_0c3d_6b94);
    AssetId::<StandardMaterial>::Uuid { uuid: UNKNOWN }.untyped()
}

/// Assigns table indices to meshes of unknown materials, whose voxel material is defined only by their
/// [`MeshVoxelMaterial`]; runs after the systems of the known materials.
pub(crate) fn update_unknown_materials(
    mut commands: Commands,
    columns: Query<(Entity, Ref<MeshVoxelMaterial>), With<Mesh3d>>,
    all: Query<(&MeshVoxelMaterial, Option<&MaterialIndex>), With<Mesh3d>>,
    moved: Res<MovedMeshes>,
    indices: Query<&MaterialIndex>,
    mut table: ResMut<MaterialTable>,
    mut session: Local<u64>,
) {
    let mut changed: HashSet<_> = moved.entities.iter().copied().collect();
    let tables = columns.contiguous_iter();
    if tables.is_err() || *session != table.session {
        changed.extend(columns.iter().map(|(entity, _)| entity));
        *session = table.session;
    }
    for (rows, overrides) in tables.into_iter().flatten() {
        for_each_changed_row(&[split(overrides).1], rows.len(), |row| {
            changed.insert(rows[row]);
        });
    }
    for entity in changed {
        let Ok((&override_, known)) = all.get(entity) else {
            if indices
                .get(entity)
                .is_ok_and(|index| index.material_type.is_none())
            {
                forget_index::<MeshVoxelMaterial>(&mut commands, entity, None);
            }
            continue;
        };
        if known.is_some_and(|known| known.material_type.is_some()) {
            continue;
        }
        let index = MaterialIndex {
            index: table.index_of(unknown(), Variant::Overridden(override_)),
            material_type: None,
        };
        if known != Some(&index) {
            commands.entity(entity).insert(index);
        }
    }
}

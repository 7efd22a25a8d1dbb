//! Keeps the material table in sync as materials and meshes change.

use std::any::TypeId;

use bevy::{ecs::entity::Entities, platform::collections::HashSet, prelude::*};
use bevy_frugal_hooks::MaterialImages;

use super::{
    changed_rows::{KnownRows, for_each_changed_row, split},
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
    all_entities: &Entities,
    mut material_events: MessageReader<AssetEvent<M>>,
    (materials, images): (Res<Assets<M>>, Res<MaterialImages>),
    mut table: ResMut<MaterialTable>,
    (mut pending, mut known_rows): (Local<MaterialUpdates<M>>, Local<KnownRows>),
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
    let mut moved = Vec::new();
    let tables = columns.contiguous_iter();
    let is_dense = tables.is_ok();
    for (rows, handles, own) in tables.into_iter().flatten() {
        known_rows.update(rows, all_entities, &mut moved);
        let columns = [split(handles).1, own.and_then(|own| split(own).1)];
        for_each_changed_row(&columns, rows.len(), |row| {
            entities.insert(rows[row]);
        });
    }
    if is_new_session || !is_dense {
        entities.extend(all.iter().map(|(entity, ..)| entity));
    }
    if !is_dense {
        let rows: Vec<_> = all.iter().map(|(entity, ..)| entity).collect();
        known_rows.update(&rows, all_entities, &mut moved);
    }
    known_rows.finish(&mut moved);
    for entity in moved {
        if all.contains(entity) {
            entities.insert(entity);
        } else if let Ok(mut entity) = commands.get_entity(entity) {
            // It may be only disabled, or have another type of material by now, whose index it must keep.
            entity.queue_silenced(move |mut entity: EntityWorldMut| {
                let index = entity.get::<MaterialIndex>();
                let is_this = index.is_some_and(|index| index.material_type == this);
                if is_this && !entity.contains::<MeshMaterial3d<M>>() {
                    entity.remove::<MaterialIndex>();
                }
            });
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

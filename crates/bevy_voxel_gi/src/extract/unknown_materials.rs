//! Meshes of unknown materials, whose voxel material is defined only by their [`MeshVoxelMaterial`].

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    ecs::entity::Entities,
    platform::collections::HashSet,
    prelude::*,
};

use super::{
    changed_rows::{KnownRows, for_each_changed_row, split},
    material_table::{MaterialIndex, MaterialTable, Variant},
};
use crate::settings::MeshVoxelMaterial;

/// A material id that no asset has; all of these meshes share it in the table.
fn unknown() -> UntypedAssetId {
    const UNKNOWN: Uuid = Uuid::from_u128(0x9f0b_5a4e_31c6_4d7b_8a52_77e1_0c3d_6b94);
    AssetId::<StandardMaterial>::Uuid { uuid: UNKNOWN }.untyped()
}

/// Assigns them table indices; runs after the systems of the known materials.
pub(crate) fn update_unknown_materials(
    mut commands: Commands,
    columns: Query<(Entity, Ref<MeshVoxelMaterial>), With<Mesh3d>>,
    all: Query<(&MeshVoxelMaterial, Option<&MaterialIndex>), With<Mesh3d>>,
    entities: &Entities,
    mut table: ResMut<MaterialTable>,
    (mut rows, mut session): (Local<KnownRows>, Local<u64>),
) {
    let mut changed = Vec::new();
    if let Ok(tables) = columns.contiguous_iter() {
        for (entity_rows, overrides) in tables {
            rows.update(entity_rows, entities, &mut changed);
            for_each_changed_row(&[split(overrides).1], entity_rows.len(), |row| {
                changed.push(entity_rows[row]);
            });
        }
        rows.finish(&mut changed);
    }
    if columns.contiguous_iter().is_err() || *session != table.session {
        changed.extend(columns.iter().map(|(entity, _)| entity));
        *session = table.session;
    }
    let changed: HashSet<_> = changed.into_iter().collect();
    for entity in changed {
        let Ok((&override_, known)) = all.get(entity) else {
            // The entity may be gone, or only disabled, or have got a known material.
            if let Ok(mut entity) = commands.get_entity(entity) {
                entity.queue_silenced(|mut entity: EntityWorldMut| {
                    let index = entity.get::<MaterialIndex>();
                    let is_unknown = index.is_some_and(|index| index.material_type.is_none());
                    if is_unknown && !entity.contains::<MeshVoxelMaterial>() {
                        entity.remove::<MaterialIndex>();
                    }
                });
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

//! Meshes of unknown materials, whose voxel material is defined only by their [`MeshVoxelMaterial`].

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    platform::collections::HashSet,
    prelude::*,
};

use super::{
    changed_rows::{MovedMeshes, for_each_changed_row, split},
    material_table::{MaterialIndex, MaterialTable, Variant},
    update_materials::forget_index,
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

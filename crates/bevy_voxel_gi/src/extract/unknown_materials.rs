//! Meshes of unknown materials, whose voxel material is defined only by their [`MeshVoxelMaterial`].

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    prelude::*,
};

use super::{
    material_table::{MaterialIndex, MaterialTable, Variant},
    voxel_material::VoxelMaterial,
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
    new: Query<
        Entity,
        (
            With<Mesh3d>,
            With<MeshVoxelMaterial>,
            Without<MaterialIndex>,
        ),
    >,
    known: Query<&MaterialIndex>,
    overrides: Query<&MeshVoxelMaterial>,
    mut without: RemovedComponents<MeshVoxelMaterial>,
    mut table: ResMut<MaterialTable>,
) {
    for entity in &new {
        let index = table.index_of(unknown(), Variant::Own(entity));
        commands.entity(entity).insert(MaterialIndex {
            index,
            material_type: None,
        });
    }
    for entity in without.read() {
        if known
            .get(entity)
            .is_ok_and(|index| index.material_type.is_none())
        {
            commands.entity(entity).remove::<MaterialIndex>();
        }
    }
    table.set(unknown(), VoxelMaterial::NEUTRAL, |variant, neutral| {
        let Variant::Own(entity) = variant else {
            return neutral;
        };
        overrides
            .get(entity)
            .map_or(neutral, |override_| neutral.overridden_by(override_))
    });
}

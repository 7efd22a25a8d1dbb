//! Meshes of unknown materials, whose surface is defined only by their [`MeshVoxelMaterial`].

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    prelude::*,
};

use super::{
    material_table::{MaterialIndex, MaterialTable, MeshVoxelMaterial, Variant},
    voxel_material::VoxelMaterial,
};

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
    own: Query<&MeshVoxelMaterial>,
    mut without: RemovedComponents<MeshVoxelMaterial>,
    mut surfaces: ResMut<MaterialTable>,
) {
    for entity in &new {
        let place = surfaces.place(unknown(), Variant::Own(entity));
        commands.entity(entity).insert(MaterialIndex {
            place,
            material: None,
        });
    }
    for entity in without.read() {
        if known
            .get(entity)
            .is_ok_and(|index| index.material.is_none())
        {
            commands.entity(entity).remove::<MaterialIndex>();
        }
    }
    surfaces.set(unknown(), VoxelMaterial::NEUTRAL, |variant, neutral| {
        let Variant::Own(entity) = variant else {
            return neutral;
        };
        own.get(entity).map_or(neutral, |own| own.over(neutral))
    });
}

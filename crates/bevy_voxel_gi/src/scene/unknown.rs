//! Meshes of unknown materials, whose surface is defined only by their [`MeshSurface`].

use bevy::{
    asset::{UntypedAssetId, uuid::Uuid},
    prelude::*,
};

use super::{
    surface::VoxelSurface,
    table::{MeshSurface, SurfaceIndex, Surfaces, Variant},
};

/// A material id that no asset has; all of these meshes share it in the table.
fn unknown() -> UntypedAssetId {
    const UNKNOWN: Uuid = Uuid::from_u128(0x9f0b_5a4e_31c6_4d7b_8a52_77e1_0c3d_6b94);
    AssetId::<StandardMaterial>::Uuid { uuid: UNKNOWN }.untyped()
}

/// Assigns them table indices; runs after the systems of the known materials.
pub(crate) fn update_unknown(
    mut commands: Commands,
    new: Query<Entity, (With<Mesh3d>, With<MeshSurface>, Without<SurfaceIndex>)>,
    known: Query<&SurfaceIndex>,
    own: Query<&MeshSurface>,
    mut without: RemovedComponents<MeshSurface>,
    mut surfaces: ResMut<Surfaces>,
) {
    for entity in &new {
        let place = surfaces.place(unknown(), Variant::Own(entity));
        commands.entity(entity).insert(SurfaceIndex {
            place,
            material: None,
        });
    }
    for entity in without.read() {
        if known
            .get(entity)
            .is_ok_and(|index| index.material.is_none())
        {
            commands.entity(entity).remove::<SurfaceIndex>();
        }
    }
    surfaces.set(unknown(), VoxelSurface::NEUTRAL, |variant, neutral| {
        let Variant::Own(entity) = variant else {
            return neutral;
        };
        own.get(entity).map_or(neutral, |own| own.over(neutral))
    });
}

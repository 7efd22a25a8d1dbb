//! The bounds of meshes that Bevy keeps none of, as they are never culled: view models, skies, and what a shader
//! displaces.

use bevy::{
    camera::primitives::{Aabb, MeshAabb},
    prelude::*,
};

use crate::settings::NotVoxelized;

/// The bounds of the mesh's own vertices, of which voxels are made.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct OwnBounds(pub Aabb);

type HasNone = (Without<Aabb>, Without<NotVoxelized>);

/// Keeps the bounds of meshes without [`Aabb`].
pub(crate) fn find_own_bounds(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    new: Query<(Entity, &Mesh3d), (HasNone, Without<OwnBounds>)>,
    mut changed: Query<
        (&Mesh3d, &mut OwnBounds),
        (HasNone, Or<(AssetChanged<Mesh3d>, Changed<Mesh3d>)>),
    >,
) {
    let bounds = |mesh: &Mesh3d| meshes.get(mesh).and_then(MeshAabb::get_aabb);
    for (entity, mesh) in &new {
        if let Some(bounds) = bounds(mesh) {
            commands.entity(entity).try_insert(OwnBounds(bounds));
        }
    }
    for (mesh, mut own) in &mut changed {
        if let Some(bounds) = bounds(mesh) {
            own.0 = bounds;
        }
    }
}

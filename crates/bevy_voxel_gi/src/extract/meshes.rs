//! Extracts the meshes, including those outside of every view, which Bevy's own extraction leaves out: rigid ones
//! when they change. [`deformed_meshes`](super::deformed_meshes) extracts those with a skin or morph targets.

use bevy::{
    camera::{
        primitives::{Aabb, MeshAabb},
        visibility::{RenderLayers, VisibilityRange},
    },
    light::NotShadowCaster,
    math::{Affine3A, Vec3A},
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
    render::Extract,
};

use super::{
    changed_rows::{MovedMeshes, for_each_changed_row, split},
    material_table::{MaterialIndex, MaterialTable},
    outer_levels::WorldBounds,
    place_volume::ActiveVolume,
    placement::PlacedLevel,
    scene_meshes::SceneMeshes,
    voxel_material::VoxelMaterial,
};
use crate::settings::NotVoxelized;

/// A mesh of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExtractedMesh {
    pub mesh: AssetId<Mesh>,
    pub world_from_local: Affine3A,
    /// Index of its material in the table.
    pub material: u32,
    /// Index of the first of its joint matrices, if it is skinned.
    pub first_joint: Option<u32>,
    /// Index of the matrix at which its morph weights start, 16 in each, and the number of weights.
    pub weights: Option<(u32, u32)>,
    /// Hash of these matrices and weights.
    pub pose: u64,
    /// Whether it shadows direct light.
    pub casts_shadow: bool,
    /// Centre and half extents of its bounds in world space; `None` if they are not known.
    pub bounds: Option<(Vec3A, Vec3A)>,
    /// Whether Bevy keeps its bounds, too: what is never culled may be a sky.
    pub is_culled: bool,
}

impl ExtractedMesh {
    /// Whether it may reach into a level.
    pub(crate) fn reaches(&self, level: &PlacedLevel) -> bool {
        let Some((center, half_size)) = self.bounds else {
            return true;
        };
        let half = Vec3A::splat(0.5 * level.size);
        let distance = (center - Vec3A::from(level.center)).abs() - half_size;
        distance.cmple(half).all()
    }

    #[cfg(test)]
    pub(super) fn with_bounds(bounds: Option<(Vec3A, Vec3A)>) -> Self {
        Self {
            mesh: AssetId::default(),
            world_from_local: default(),
            material: 0,
            first_joint: None,
            weights: None,
            pose: 0,
            casts_shadow: true,
            bounds,
            is_culled: true,
        }
    }

    /// Whether it has a skin or morph targets.
    pub(crate) fn is_deformed(&self) -> bool {
        self.first_joint.is_some() || self.weights.is_some()
    }

    /// Whether it counts from afar, where what is shorter than this in metres is not resolved: characters never do.
    pub(crate) fn is_landscape(&self, resolved: f32) -> bool {
        let is_large = |(_, half_size): (Vec3A, Vec3A)| 2.0 * half_size.max_element() >= resolved;
        !self.is_deformed() && self.bounds.is_none_or(is_large)
    }
}

/// Centre and half extents in world space of bounds in local space; `None` if these are not finite.
pub(super) fn world_bounds(local: &Aabb, world_from_local: &Affine3A) -> Option<(Vec3A, Vec3A)> {
    let m = world_from_local.matrix3;
    let half_size = m.x_axis.abs() * local.half_extents.x
        + m.y_axis.abs() * local.half_extents.y
        + m.z_axis.abs() * local.half_extents.z;
    let center = world_from_local.transform_point3a(local.center);
    (center.is_finite() && half_size.is_finite()).then_some((center, half_size))
}

/// The scene to voxelise.
#[derive(Resource, Default)]
pub(crate) struct ExtractedScene {
    /// The rigid meshes, wherever they are, and the deformed ones that reach into a level.
    pub meshes: SceneMeshes,
    /// The deformed ones.
    pub deformed: Vec<Entity>,
    /// Matrices from bind pose to world, of all skins; then weights of morph targets, 16 in each.
    pub joints: Vec<Mat4>,
    /// The table of materials.
    pub materials: Vec<VoxelMaterial>,
    /// Version of the table; `None` if no mesh is extracted.
    pub materials_version: Option<u64>,
    /// The bounds of the rigid meshes.
    pub world: WorldBounds,
    /// The layers of the meshes that count.
    layers: RenderLayers,
}

/// The components that voxelisation reads of any mesh.
pub(super) type MeshParts = (
    &'static Mesh3d,
    &'static GlobalTransform,
    &'static InheritedVisibility,
    Option<&'static Aabb>,
    Option<&'static OwnBounds>,
    Option<&'static MaterialIndex>,
    Option<&'static RenderLayers>,
    Option<&'static VisibilityRange>,
    Has<NotShadowCaster>,
);

/// [`MeshParts`] of an entity.
pub(super) type MeshItem<'a> = (
    &'a Mesh3d,
    &'a GlobalTransform,
    &'a InheritedVisibility,
    Option<&'a Aabb>,
    Option<&'a OwnBounds>,
    Option<&'a MaterialIndex>,
    Option<&'a RenderLayers>,
    Option<&'a VisibilityRange>,
    bool,
);

type IsRigid = (
    Without<NotVoxelized>,
    Without<SkinnedMesh>,
    Without<MeshMorphWeights>,
);

/// [`MeshParts`] by tables, with their ticks.
type MeshColumns = (
    Entity,
    Ref<'static, Mesh3d>,
    Ref<'static, GlobalTransform>,
    Ref<'static, InheritedVisibility>,
    Option<Ref<'static, Aabb>>,
    Option<Ref<'static, OwnBounds>>,
    Option<Ref<'static, MaterialIndex>>,
    Option<Ref<'static, RenderLayers>>,
    Option<Ref<'static, VisibilityRange>>,
    Has<NotShadowCaster>,
);

impl ExtractedScene {
    /// Takes over the materials, and returns whether any mesh may have come or gone by that.
    fn update_materials(&mut self, table: &MaterialTable) -> bool {
        if self.materials_version.replace(table.version) == Some(table.version) {
            return false;
        }
        let before = std::mem::replace(&mut self.materials, table.materials().to_vec());
        let mut pairs = before.iter().zip(&self.materials);
        pairs.any(|(before, now)| before.transparent != now.transparent)
    }

    /// The mesh as it is voxelised without a skin; `None` if it is not.
    pub(super) fn rigid_mesh(
        &self,
        (mesh, transform, visible, aabb, own, index, layers, range, casts_none): MeshItem<'_>,
    ) -> Option<ExtractedMesh> {
        // Of the levels of detail, the one that is seen from nearby: it is the same wherever cameras are.
        let is_nearest = range.is_none_or(|range| range.is_visible_at_all(0.0));
        if !layers.unwrap_or_default().intersects(&self.layers) || !is_nearest {
            return None;
        }
        let index = index.copied().unwrap_or_default().index;
        let material = self.materials.get(index as usize);
        let is_transparent = material.is_some_and(|material| material.transparent);
        let world_from_local = transform.affine();
        if !visible.get() || is_transparent || !world_from_local.is_finite() {
            return None;
        }
        let bounds = aabb.or(own.map(|own| &own.0));
        let bounds = bounds.and_then(|bounds| world_bounds(bounds, &world_from_local));
        Some(ExtractedMesh {
            mesh: mesh.id(),
            world_from_local,
            material: index,
            first_joint: None,
            weights: None,
            pose: 0,
            casts_shadow: !casts_none,
            bounds,
            is_culled: aabb.is_some(),
        })
    }
}

/// Extracts the materials and the rigid meshes.
pub(crate) fn extract_scene(
    mut scene: ResMut<ExtractedScene>,
    active: Extract<Res<ActiveVolume>>,
    table: Extract<Res<MaterialTable>>,
    all_rigid: Extract<Query<(Entity, MeshParts), IsRigid>>,
    columns: Extract<Query<MeshColumns, IsRigid>>,
    moved: Extract<Res<MovedMeshes>>,
) {
    let scene = &mut *scene;
    let Some(volume) = &active.volume else {
        return;
    };
    scene.meshes.begin_frame();
    let mut extracts_all = scene.layers != volume.scene_layers;
    if extracts_all {
        scene.layers = volume.scene_layers.clone();
    }
    // While there is no volume, nothing is known of what changes.
    extracts_all |= scene.materials_version.is_none();
    extracts_all |= scene.update_materials(&table);
    if let Ok(tables) = columns.contiguous_iter() {
        for (
            entity_rows,
            meshes,
            transforms,
            visible,
            aabbs,
            own,
            indices,
            layers,
            ranges,
            casts_none,
        ) in tables
        {
            let (meshes, of_meshes) = split(meshes);
            let (transforms, of_transforms) = split(transforms);
            let (visible, of_visible) = split(visible);
            let (aabbs, of_aabbs) = aabbs.map(split).unzip();
            let (own, of_own) = own.map(split).unzip();
            let (indices, of_indices) = indices.map(split).unzip();
            let (layers, of_layers) = layers.map(split).unzip();
            let (ranges, of_ranges) = ranges.map(split).unzip();
            let columns = [
                of_meshes,
                of_transforms,
                of_visible,
                of_aabbs.flatten(),
                of_own.flatten(),
                of_indices.flatten(),
                of_layers.flatten(),
                of_ranges.flatten(),
            ];
            for_each_changed_row(&columns, entity_rows.len(), |row| {
                let mesh = scene.rigid_mesh((
                    &meshes[row],
                    &transforms[row],
                    &visible[row],
                    aabbs.map(|aabbs| &aabbs[row]),
                    own.map(|own| &own[row]),
                    indices.map(|indices| &indices[row]),
                    layers.map(|layers| &layers[row]),
                    ranges.map(|ranges| &ranges[row]),
                    casts_none,
                ));
                scene.meshes.set(entity_rows[row], mesh);
            });
        }
    } else {
        warn_once!(
            "voxel GI: a component that disables entities is in a sparse set, so all meshes are extracted in each \
             frame, which takes milliseconds for 100,000 meshes. Give it `StorageType::Table`"
        );
        extracts_all = true;
    }
    if extracts_all {
        for (entity, parts) in &all_rigid {
            let mesh = scene.rigid_mesh(parts);
            scene.meshes.set(entity, mesh);
        }
    }
    for &entity in &moved.entities {
        let mesh = match all_rigid.get(entity) {
            Ok((_, parts)) => scene.rigid_mesh(parts),
            // Those that were deformed are extracted after these.
            Err(_)
                if scene
                    .meshes
                    .get(entity)
                    .is_some_and(|mesh| mesh.is_deformed()) =>
            {
                continue;
            }
            Err(_) => None,
        };
        scene.meshes.set(entity, mesh);
    }
}

/// The bounds of the vertices of a mesh of which Bevy keeps none, as it is never culled: view models, skies, and what a
/// shader displaces.
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

//! Extracts the meshes, including those outside of every view, which Bevy's own extraction leaves out: rigid ones
//! when they change. Those with a skin or morph targets are those of [`deformed_meshes`](super::deformed_meshes).

use bevy::{
    camera::primitives::Aabb,
    ecs::entity::EntityHashMap,
    math::{Affine3A, Vec3A},
    mesh::{morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
    render::Extract,
};

use super::{
    changed_rows::{for_each_changed_row, split},
    material_order::sorted_by_value,
    material_table::{MaterialIndex, MaterialTable},
    place_volume::ActiveVolume,
    placement::{PlacedLevel, PlacedVolume},
    voxel_material::VoxelMaterial,
};
use crate::settings::{NotVoxelized, VoxelAlbedo};

/// A mesh of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExtractedMesh {
    pub mesh: AssetId<Mesh>,
    pub world_from_local: Affine3A,
    /// Index of its material.
    pub material: u32,
    /// Index of the first of its joint matrices, if it is skinned.
    pub first_joint: Option<u32>,
    /// Index of the matrix at which its morph weights start, 16 in each, and the number of weights.
    pub weights: Option<(u32, u32)>,
    /// Centre and half extents of its bounds in world space; `None` if they are not known.
    pub bounds: Option<(Vec3A, Vec3A)>,
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
}

/// The scene to voxelise.
#[derive(Resource, Default)]
pub(crate) struct ExtractedScene {
    /// The meshes without skin and morph targets, wherever they are.
    pub rigid: EntityHashMap<ExtractedMesh>,
    /// The rigid meshes that changed or went in this frame; `None` if any of them may have.
    pub changed: Option<Vec<Entity>>,
    /// The meshes with a skin or morph targets.
    pub deformed: Vec<ExtractedMesh>,
    /// Matrices from bind pose to world, of all skins; then weights of morph targets, 16 in each.
    pub joints: Vec<Mat4>,
    /// The materials in use, sorted; see [`sorted_by_value`].
    pub materials: Vec<VoxelMaterial>,
    /// Index into `materials` for each entry of the unsorted table.
    indices: Vec<u32>,
    /// Version of the unsorted table, and whether all albedo is neutral; `None` if no mesh is extracted.
    version: Option<(u64, bool)>,
    /// Increases when a mesh asset changes.
    pub mesh_edits: u64,
}

/// The components that voxelisation reads of any mesh.
pub(super) type MeshParts = (
    &'static Mesh3d,
    &'static GlobalTransform,
    &'static InheritedVisibility,
    Option<&'static Aabb>,
    Option<&'static MaterialIndex>,
);

/// [`MeshParts`] of an entity.
pub(super) type MeshItem<'a> = (
    &'a Mesh3d,
    &'a GlobalTransform,
    &'a InheritedVisibility,
    Option<&'a Aabb>,
    Option<&'a MaterialIndex>,
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
    Option<Ref<'static, MaterialIndex>>,
);

/// Components that make a mesh no rigid one.
type IsNoLongerRigid = Or<(
    Added<NotVoxelized>,
    Added<SkinnedMesh>,
    Added<MeshMorphWeights>,
)>;

/// Components whose removal changes what a mesh is.
type Removals<'w, 's> = (
    RemovedComponents<'w, 's, Mesh3d>,
    RemovedComponents<'w, 's, Aabb>,
    RemovedComponents<'w, 's, MaterialIndex>,
    RemovedComponents<'w, 's, NotVoxelized>,
    RemovedComponents<'w, 's, SkinnedMesh>,
    RemovedComponents<'w, 's, MeshMorphWeights>,
);

impl ExtractedScene {
    /// Takes over the materials, and returns whether what meshes use of theirs has changed.
    fn update_materials(&mut self, table: &MaterialTable, volume: &PlacedVolume) -> bool {
        let neutral = volume.settings.albedo == VoxelAlbedo::Neutral;
        let version = Some((table.version, neutral));
        if self.version == version {
            return false;
        }
        self.version = version;
        let mut materials = table.materials().to_vec();
        if neutral {
            for material in &mut materials {
                material.albedo = VoxelMaterial::NEUTRAL.albedo;
            }
        }
        let (materials, indices) = sorted_by_value(&materials);
        let of_mesh = |material: &VoxelMaterial| {
            let coverage = material.coverage.to_bits();
            (material.transparent, material.double_sided, coverage)
        };
        let is_same = self.indices == indices
            && (self.materials.iter().map(of_mesh)).eq(materials.iter().map(of_mesh));
        (self.materials, self.indices) = (materials, indices);
        !is_same
    }

    /// The mesh as it is voxelised; `None` if it is not.
    pub(super) fn rigid_mesh(
        &self,
        (mesh, transform, visible, aabb, index): MeshItem<'_>,
    ) -> Option<ExtractedMesh> {
        let index = index.copied().unwrap_or_default().index;
        let material = self.indices.get(index as usize).copied().unwrap_or(0);
        let transparent = self
            .materials
            .get(material as usize)
            .is_some_and(|material| material.transparent == 1);
        let world_from_local = transform.affine();
        if !visible.get() || transparent || !world_from_local.is_finite() {
            return None;
        }
        let bounds = aabb.map(|aabb| {
            let m = world_from_local.matrix3;
            let half_size = m.x_axis.abs() * aabb.half_extents.x
                + m.y_axis.abs() * aabb.half_extents.y
                + m.z_axis.abs() * aabb.half_extents.z;
            (world_from_local.transform_point3a(aabb.center), half_size)
        });
        Some(ExtractedMesh {
            mesh: mesh.id(),
            world_from_local,
            material,
            first_joint: None,
            weights: None,
            bounds,
        })
    }

    /// Stores what a rigid mesh is now.
    fn set_rigid(&mut self, entity: Entity, mesh: Option<ExtractedMesh>) {
        let former = match mesh {
            Some(mesh) => self.rigid.insert(entity, mesh),
            None => self.rigid.remove(&entity),
        };
        if former != mesh
            && let Some(changed) = &mut self.changed
        {
            changed.push(entity);
        }
    }
}

/// Extracts the materials and the rigid meshes.
pub(crate) fn extract_scene(
    mut scene: ResMut<ExtractedScene>,
    active: Extract<Res<ActiveVolume>>,
    table: Extract<Res<MaterialTable>>,
    mut mesh_events: Extract<MessageReader<AssetEvent<Mesh>>>,
    rigid: Extract<Query<MeshParts, IsRigid>>,
    all_rigid: Extract<Query<(Entity, MeshParts), IsRigid>>,
    columns: Extract<Query<MeshColumns, IsRigid>>,
    no_longer_rigid: Extract<Query<Entity, IsNoLongerRigid>>,
    mut removals: Extract<Removals>,
) {
    let scene = &mut *scene;
    let edited = mesh_events
        .read()
        .any(|event| matches!(event, AssetEvent::Modified { .. }));
    scene.mesh_edits += u64::from(edited);
    let (a, b, c, d, e, f) = &mut *removals;
    let removed = a.read().chain(b.read()).chain(c.read());
    let removed = removed.chain(d.read()).chain(e.read()).chain(f.read());
    let Some(volume) = &active.volume else {
        removed.for_each(drop);
        *scene = ExtractedScene {
            mesh_edits: scene.mesh_edits,
            ..default()
        };
        return;
    };
    if scene.update_materials(&table, volume) {
        removed.for_each(drop);
        scene.changed = None;
        scene.rigid.clear();
        for (entity, parts) in &all_rigid {
            let mesh = scene.rigid_mesh(parts);
            scene.set_rigid(entity, mesh);
        }
        return;
    }
    scene.changed = Some(Vec::new());
    let tables = columns.contiguous_iter();
    for table in tables.expect("none of these components is in a sparse set") {
        let (entities, meshes, transforms, visible, aabbs, indices) = table;
        let (meshes, of_meshes) = split(meshes);
        let (transforms, of_transforms) = split(transforms);
        let (visible, of_visible) = split(visible);
        let (aabbs, of_aabbs) = aabbs.map(split).unzip();
        let (indices, of_indices) = indices.map(split).unzip();
        let columns = [
            of_meshes,
            of_transforms,
            of_visible,
            of_aabbs.flatten(),
            of_indices.flatten(),
        ];
        for_each_changed_row(&columns, entities.len(), |row| {
            let mesh = scene.rigid_mesh((
                &meshes[row],
                &transforms[row],
                &visible[row],
                aabbs.map(|aabbs| &aabbs[row]),
                indices.map(|indices| &indices[row]),
            ));
            scene.set_rigid(entities[row], mesh);
        });
    }
    for entity in removed.chain(&no_longer_rigid) {
        let mesh = rigid.get(entity).ok();
        let mesh = mesh.and_then(|parts| scene.rigid_mesh(parts));
        scene.set_rigid(entity, mesh);
    }
}

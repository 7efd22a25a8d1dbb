//! Extracts the meshes, including those outside of every view, which Bevy's own extraction leaves out: rigid ones
//! when they change. [`deformed_meshes`](super::deformed_meshes) extracts those with a skin or morph targets.
//! They are kept from frame to frame.

use bevy::{
    camera::{
        primitives::{Aabb, MeshAabb},
        visibility::{RenderLayers, VisibilityRange},
    },
    ecs::{entity::EntityIndexMap, query::QueryData},
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
    voxel_material::VoxelMaterial,
};
use crate::{prepare::mesh_batches::PlacedMesh, settings::NotVoxelized};

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
    pub materials: Vec<VoxelMaterial>,
    /// Version of the table; `None` if no mesh is extracted.
    pub materials_version: Option<u64>,
    /// The bounds of the rigid meshes.
    pub world: WorldBounds,
    /// The layers of the meshes that count.
    layers: RenderLayers,
}

/// The components that voxelisation reads of any mesh.
#[derive(QueryData)]
pub(crate) struct MeshParts {
    mesh: &'static Mesh3d,
    transform: &'static GlobalTransform,
    visible: &'static InheritedVisibility,
    aabb: Option<&'static Aabb>,
    own: Option<&'static OwnBounds>,
    index: Option<&'static MaterialIndex>,
    layers: Option<&'static RenderLayers>,
    range: Option<&'static VisibilityRange>,
    casts_none: Has<NotShadowCaster>,
}

impl MeshPartsItem<'_, '_> {
    /// Bounds in the mesh's own space.
    pub(super) fn shape(&self) -> Option<&Aabb> {
        self.aabb.or(self.own.map(|own| &own.0))
    }
}

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
    pub(super) fn rigid_mesh(&self, parts: &MeshPartsItem) -> Option<ExtractedMesh> {
        // Of the levels of detail, the one that is seen from nearby: it is the same wherever cameras are.
        let is_nearest = (parts.range).is_none_or(|range| range.is_visible_at_all(0.0));
        let layers = parts.layers.unwrap_or_default();
        if !layers.intersects(&self.layers) || !is_nearest {
            return None;
        }
        let index = parts.index.copied().unwrap_or_default().index;
        let material = self.materials.get(index as usize);
        let is_transparent = material.is_some_and(|material| material.transparent);
        let world_from_local = parts.transform.affine();
        if !parts.visible.get() || is_transparent || !world_from_local.is_finite() {
            return None;
        }
        let bounds = parts.shape();
        let bounds = bounds.and_then(|bounds| world_bounds(bounds, &world_from_local));
        Some(ExtractedMesh {
            mesh: parts.mesh.id(),
            world_from_local,
            material: index,
            first_joint: None,
            weights: None,
            pose: 0,
            casts_shadow: !parts.casts_none,
            bounds,
            is_culled: parts.aabb.is_some(),
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
                let mesh = scene.rigid_mesh(&MeshPartsItem {
                    mesh: &meshes[row],
                    transform: &transforms[row],
                    visible: &visible[row],
                    aabb: aabbs.map(|aabbs| &aabbs[row]),
                    own: own.map(|own| &own[row]),
                    index: indices.map(|indices| &indices[row]),
                    layers: layers.map(|layers| &layers[row]),
                    range: ranges.map(|ranges| &ranges[row]),
                    casts_none,
                });
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
            let mesh = scene.rigid_mesh(&parts);
            scene.meshes.set(entity, mesh);
        }
    }
    for &entity in &moved.entities {
        let mesh = match all_rigid.get(entity) {
            Ok((_, parts)) => scene.rigid_mesh(&parts),
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

/// A mesh of the scene.
#[derive(Default)]
pub(crate) struct SceneMesh {
    /// The mesh in this frame; `None` if it has gone.
    pub now: Option<ExtractedMesh>,
    /// Its place in the groups, if it is voxelised.
    pub placed: Option<PlacedMesh>,
}

/// The meshes of the scene. Those that have changed lately come first, in the order in which they change, so that what
/// moves is read from memory in a row.
#[derive(Default)]
pub(crate) struct SceneMeshes {
    all: EntityIndexMap<SceneMesh>,
    /// Number of those that have changed lately: at most a quarter of all, or twice as many as change in a frame.
    recent: usize,
    /// The indices of those that changed or went in this frame.
    changed: Vec<usize>,
    /// The meshes that rested until this frame, as they were.
    left: Vec<ExtractedMesh>,
    /// Whether the resting meshes are other ones than when their bounds were found.
    rest_is_new: bool,
}

impl SceneMeshes {
    pub(super) fn begin_frame(&mut self) {
        let most = (2 * self.changed.len()).max(self.all.len() / 4);
        if self.recent > most {
            self.forget_recent();
        }
        self.changed.clear();
        self.left.clear();
    }

    fn forget_recent(&mut self) {
        self.recent = 0;
        self.rest_is_new = true;
    }

    /// Stores what a mesh is now.
    pub(super) fn set(&mut self, entity: Entity, mesh: Option<ExtractedMesh>) {
        // Where what moves is the same from frame to frame, it is the next one.
        let next = self.changed.last().map_or(0, |last| last + 1);
        let is_next = self.all.get_index(next).is_some_and(|(e, _)| *e == entity);
        let known = if is_next {
            Some(next)
        } else {
            self.all.get_index_of(&entity)
        };
        let mut index = match (known, &mesh) {
            (Some(index), _) => index,
            (None, Some(_)) => self.all.insert_full(entity, default()).0,
            (None, None) => return,
        };
        if self.all[index].now == mesh {
            return;
        }
        if index >= self.recent {
            self.left.extend(self.all[index].now);
            self.all.swap_indices(index, self.recent);
            index = self.recent;
            self.recent += 1;
        }
        self.all[index].now = mesh;
        self.changed.push(index);
    }

    pub(super) fn get(&self, entity: Entity) -> Option<ExtractedMesh> {
        self.all.get(&entity)?.now
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &SceneMesh> {
        self.all.values()
    }

    /// The meshes that have changed lately, and the resting ones.
    pub(super) fn recent_and_resting(&self) -> [impl Iterator<Item = &ExtractedMesh>; 2] {
        let meshes = self.all.as_slice();
        let (recent, resting) = meshes.split_at(self.recent);
        [recent, resting].map(|meshes| meshes.values().filter_map(|mesh| mesh.now.as_ref()))
    }

    /// The meshes that rested until this frame, as they were; `None` if the others are not those of the last call.
    pub(super) fn take_left(&mut self) -> Option<Vec<ExtractedMesh>> {
        let left = std::mem::take(&mut self.left);
        (!std::mem::take(&mut self.rest_is_new)).then_some(left)
    }

    /// Calls a function with those that changed in this frame.
    pub(crate) fn update_changed(&mut self, mut update: impl FnMut(&mut SceneMesh)) {
        let mut gone = Vec::new();
        for index in &self.changed {
            if let Some((entity, mesh)) = self.all.get_index_mut(*index) {
                update(mesh);
                if mesh.now.is_none() {
                    gone.push(*entity);
                }
            }
        }
        for entity in gone {
            if let Some(index) = self.all.get_index_of(&entity) {
                // One that rests takes its place, which must not be among the recent ones.
                self.recent -= 1;
                self.all.swap_indices(index, self.recent);
                self.all.swap_remove_index(self.recent);
            }
        }
    }

    /// Calls a function with all of them, and with whether they changed in this frame.
    pub(crate) fn update_all(&mut self, mut update: impl FnMut(&mut SceneMesh, bool)) {
        let mut has_changed = vec![false; self.all.len()];
        for index in &self.changed {
            has_changed[*index] = true;
        }
        let mut has_changed = has_changed.into_iter();
        let count = self.all.len();
        self.all.retain(|_, mesh| {
            update(mesh, has_changed.next() == Some(true));
            mesh.now.is_some()
        });
        if self.all.len() < count {
            self.forget_recent();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn mesh(material: u32) -> ExtractedMesh {
        ExtractedMesh {
            material,
            ..ExtractedMesh::with_bounds(None)
        }
    }

    /// What is kept is what was set last, exactly what has changed is updated, and what rests has not changed since it
    /// was asked for.
    #[test]
    fn meshes_that_come_move_and_go_are_those_of_a_plain_map() {
        let mut meshes = SceneMeshes::default();
        let mut expected = BTreeMap::new();
        let mut resting: Option<Vec<u32>> = None;
        let mut state = 7_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for frame in 0..400 {
            meshes.begin_frame();
            let before = expected.clone();
            // A crowd that moves, and what comes and goes.
            let crowd = (20..28).map(|id| (id, Some(1000 + frame)));
            let others = (0..random(6)).map(|_| (random(120), Some(random(3)).filter(|i| *i > 0)));
            for (id, material) in crowd.chain(others.collect::<Vec<_>>()) {
                let entity = Entity::from_raw_u32(id).expect("an index");
                meshes.set(entity, material.map(mesh));
                match material {
                    Some(material) => expected.insert(id, material),
                    None => expected.remove(&id),
                };
            }
            let [_, rest] = meshes.recent_and_resting();
            let mut rest: Vec<_> = rest.map(|mesh| mesh.material).collect();
            rest.sort_unstable();
            if let (Some(left), Some(resting)) = (meshes.take_left(), &mut resting) {
                for mesh in left {
                    let index = resting.iter().position(|m| *m == mesh.material);
                    resting.remove(index.expect("it rested"));
                }
                assert_eq!(rest, *resting, "frame {frame}");
            }
            resting = Some(rest);
            let mut updated = 0;
            if frame % 7 == 0 {
                meshes.update_all(|_, has_changed| updated += usize::from(has_changed));
            } else {
                meshes.update_changed(|_| updated += 1);
            }
            let is_other = |id: &u32| before.get(id) != expected.get(id);
            let ids = (0..120).filter(is_other).count();
            assert!(updated >= ids, "frame {frame}: {updated} of {ids}");
            assert_eq!(meshes.iter().count(), expected.len());
            for (id, material) in &expected {
                let found = meshes.get(Entity::from_raw_u32(*id).expect("an index"));
                assert_eq!(found.map(|mesh| mesh.material), Some(*material), "{id}");
            }
        }
    }
}

//! Groups meshes by the GPU buffers that they share, in batches of 64 triangles. Groups of rigid meshes are kept
//! from frame to frame, and only what has changed is located anew.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    ecs::entity::EntityHashMap,
    math::Vec3A,
    platform::{
        collections::{HashMap, HashSet},
        hash::FixedHasher,
    },
    prelude::*,
    render::{
        mesh::{
            RenderMesh,
            allocator::{MeshAllocator, MeshSlabId},
        },
        render_asset::{ExtractedAssets, RenderAssets},
        render_resource::Buffer,
        renderer::RenderDevice,
    },
};

use super::{
    asset_notes::AssetNotes,
    dirty_voxels::{Bounds, ChangedRegions},
    fingerprint::hash_floats,
    mesh_group::{LevelMask, MeshGroup},
    mesh_instance::MeshLocator,
};
use crate::{
    extract::{
        meshes::{ExtractedMesh, ExtractedScene},
        volume::ExtractedVolume,
    },
    gpu_types::{MESH_NOT_SHADOW_CASTER, MESH_SKINNED, MeshInstance},
};

/// The meshes as the voxeliser dispatches them.
#[derive(Resource, Default)]
pub(crate) struct MeshBatches {
    rigid: MeshGroups,
    deformed: MeshGroups,
    /// The deformed meshes of the last frame, by their hash with that of what deforms them.
    deformed_before: HashMap<u64, DeformedMeshes>,
    /// The rigid meshes in `rigid`.
    placed: EntityHashMap<PlacedMesh>,
    /// Sum of the hashes of the rigid meshes, which does not depend on their order.
    rigid_hash: u64,
    /// Centres and edges of the levels for which the rigid meshes were grouped.
    levels: Vec<(Vec3, f32)>,
    /// Increases when the asset of a mesh that reaches into a level has changed.
    edits: u64,
    /// By how much the world has moved in this frame, as apps move it that keep the origin near the camera: most of the
    /// rigid meshes have moved by it.
    pub world_move: Vec3,
    /// Where meshes have changed since the scene was voxelised last.
    changed: ChangedRegions,
    /// Hash of everything that the voxels depend on.
    pub fingerprint: u64,
    pub triangles: u64,
}

impl MeshBatches {
    /// Whether a mesh that reaches into a level has this material.
    pub(super) fn uses(&self, material: u32) -> bool {
        self.rigid.uses(material) || self.deformed.uses(material)
    }

    /// Whether a mesh that reaches into a level does not shadow direct light.
    pub(super) fn have_mesh_without_shadow(&self) -> bool {
        self.rigid.has_mesh_without_shadow() || self.deformed.has_mesh_without_shadow()
    }

    pub(crate) fn groups_mut(&mut self) -> impl Iterator<Item = &mut MeshGroup> {
        self.rigid.iter_mut().chain(self.deformed.iter_mut())
    }

    /// Where meshes have changed since this was asked last, or have one of these materials.
    pub(super) fn take_changed(&mut self, materials: &HashSet<u32>) -> ChangedRegions {
        let mut changed = std::mem::take(&mut self.changed);
        if !materials.is_empty() {
            let rigid = self.placed.values();
            let rigid = rigid.map(|mesh| (mesh.material, mesh.bounds, mesh.levels));
            let deformed = self.deformed_before.values();
            let deformed = deformed.map(|mesh| (mesh.material, mesh.bounds, mesh.levels));
            for (_, bounds, levels) in rigid
                .chain(deformed)
                .filter(|(material, ..)| materials.contains(material))
            {
                changed.add(bounds, levels);
            }
        }
        changed
    }

    /// Groups all rigid meshes anew.
    fn group_rigid_meshes(&mut self, locator: &MeshLocator) {
        self.rigid = MeshGroups::default();
        self.placed.clear();
        self.rigid_hash = 0;
        for &entity in locator.scene.rigid.keys() {
            self.update_rigid_mesh(entity, false, locator);
        }
    }

    /// Groups all meshes with a skin or morph targets, and returns their hash.
    fn group_deformed_meshes(
        &mut self,
        locator: &MeshLocator,
        assets: &ExtractedAssets<RenderMesh>,
    ) -> u64 {
        let scene = locator.scene;
        let mut hasher = FixedHasher.build_hasher();
        let mut found = HashMap::default();
        self.deformed = MeshGroups::default();
        let first_matrix =
            |mesh: &ExtractedMesh| mesh.first_joint.or(mesh.weights.map(|(first, _)| first));
        for (i, extracted) in scene.deformed.iter().enumerate() {
            let Some(mesh) = locator.locate(extracted) else {
                continue;
            };
            let mut own = FixedHasher.build_hasher();
            mesh.hash.hash(&mut own);
            let first = first_matrix(extracted).unwrap_or_default() as usize;
            let end = scene.deformed.get(i + 1).and_then(first_matrix);
            let end = end.map_or(scene.joints.len(), |end| end as usize);
            for joint in &scene.joints[first..end.max(first)] {
                hash_floats(&mut own, &joint.to_cols_array());
            }
            let hash = own.finish();
            hash.hash(&mut hasher);
            let alike = found.entry(hash).or_insert(DeformedMeshes {
                count: 0,
                bounds: mesh.bounds,
                levels: mesh.instance.levels,
                material: mesh.instance.material,
            });
            alike.count += 1;
            if assets.added.contains(&mesh.mesh) {
                self.changed.add(mesh.bounds, mesh.instance.levels);
            }
            self.deformed.add(mesh);
        }
        let before = std::mem::replace(&mut self.deformed_before, found);
        let now = &self.deformed_before;
        for (one, other) in [(&before, now), (now, &before)] {
            for (hash, meshes) in one {
                let others = other.get(hash);
                if others.is_none_or(|others| others.count != meshes.count) {
                    self.changed.add(meshes.bounds, meshes.levels);
                }
            }
        }
        hasher.finish()
    }

    /// Adds, changes or removes a rigid mesh. `is_edited` says whether its asset may be another one.
    fn update_rigid_mesh(&mut self, entity: Entity, is_edited: bool, locator: &MeshLocator) {
        let extracted = locator.scene.rigid.get(&entity);
        if let Some(extracted) = extracted
            && let Some(placed) = self.placed.get_mut(&entity)
            && !is_edited
            && extracted.mesh == placed.mesh
            && let Some((instance, hash)) = locator.moved(extracted, self.rigid.instance(placed))
        {
            if hash != placed.hash {
                self.changed.add(placed.bounds, placed.levels);
                self.changed.add(extracted.bounds, instance.levels);
            }
            self.rigid_hash = self.rigid_hash.wrapping_sub(placed.hash).wrapping_add(hash);
            self.rigid
                .set(placed, instance, extracted.bounds, hash, true);
            return;
        }
        let mesh = extracted.and_then(|extracted| locator.locate(extracted));
        let hash_before = self.placed.get(&entity).map(|placed| placed.hash);
        let hash = mesh.as_ref().map(|mesh| mesh.hash);
        // One that only reaches into other levels was not there, or is not any more.
        let has_changed = is_edited || hash_before.zip(hash).is_some_and(|(a, b)| a != b);
        let has_come_or_gone = hash_before.is_some() != hash.is_some();
        if let Some(placed) = self.placed.get(&entity)
            && (has_changed || has_come_or_gone)
        {
            self.changed.add(placed.bounds, placed.levels);
        }
        if let Some(mesh) = mesh.as_ref().filter(|_| has_changed || has_come_or_gone) {
            self.changed.add(mesh.bounds, mesh.instance.levels);
        }
        if let Some(placed) = self.placed.get_mut(&entity) {
            self.rigid_hash = self.rigid_hash.wrapping_sub(placed.hash);
            let mesh = mesh.as_ref();
            if mesh.is_some_and(|mesh| self.rigid.replace(placed, mesh, is_edited)) {
                self.rigid_hash = self.rigid_hash.wrapping_add(placed.hash);
                return;
            }
            self.rigid.remove(placed);
            self.placed.remove(&entity);
        }
        if let Some(mesh) = mesh {
            self.rigid_hash = self.rigid_hash.wrapping_add(mesh.hash);
            self.placed.insert(entity, self.rigid.add(mesh));
        }
    }

    /// The rigid meshes that reach into other levels than they did.
    fn in_other_levels(&self, locator: &MeshLocator) -> Vec<Entity> {
        let rigid = locator.scene.rigid.iter();
        let moved = rigid.filter(|(entity, extracted)| {
            let former = self.placed.get(*entity).map_or(0, |placed| placed.levels);
            locator.levels_of(extracted) != former
        });
        moved.map(|(entity, _)| *entity).collect()
    }

    /// The rigid meshes whose asset has changed, and those that are not grouped: theirs may be on the GPU now.
    fn with_other_assets(
        &self,
        locator: &MeshLocator,
        assets: &ExtractedAssets<RenderMesh>,
    ) -> Vec<Entity> {
        let rigid = locator.scene.rigid.iter();
        let changed = rigid.filter(|(entity, extracted)| {
            let mesh = extracted.mesh;
            assets.added.contains(&mesh)
                || locator.meshes.get(mesh).is_none()
                || !self.placed.contains_key(*entity)
        });
        changed.map(|(entity, _)| *entity).collect()
    }

    /// Whether the asset of a mesh that reaches into a level is another one than in the last frame.
    fn has_edits(&self, locator: &MeshLocator, assets: &ExtractedAssets<RenderMesh>) -> bool {
        let scene = locator.scene;
        let mut meshes = scene.rigid.values().chain(&scene.deformed);
        !assets.added.is_empty()
            && meshes.any(|extracted| {
                assets.added.contains(&extracted.mesh) && locator.levels_of(extracted) != 0
            })
    }
}

/// The slabs of vertices, indices and morph targets.
pub(super) type Slabs = [Option<MeshSlabId>; 3];

/// A mesh that is on the GPU and reaches into a level.
pub(super) struct LocatedMesh {
    pub slabs: Slabs,
    /// The buffers of the slabs.
    pub buffers: [Option<Buffer>; 3],
    pub instance: MeshInstance,
    pub mesh: AssetId<Mesh>,
    /// Bounds in the world, if they are known.
    pub bounds: Option<Bounds>,
    pub hash: u64,
}

/// The place of a mesh in the groups.
pub(super) struct PlacedMesh {
    slabs: Slabs,
    mesh: AssetId<Mesh>,
    pub material: u32,
    pub levels: LevelMask,
    pub bounds: Option<Bounds>,
    /// World position of the mesh's origin.
    pub position: Vec3,
    group: usize,
    instance: usize,
    pub hash: u64,
}

fn position(instance: &MeshInstance) -> Vec3 {
    instance.world_from_local.w_axis.truncate()
}

/// Groups by their slabs.
#[derive(Default)]
pub(super) struct MeshGroups {
    /// A group without a mesh is replaced by the next new one.
    groups: Vec<MeshGroup>,
    by_slabs: HashMap<Slabs, usize>,
    /// Number of triangles of all meshes.
    pub triangles: u64,
    /// Number of meshes with each material.
    materials: HashMap<u32, usize>,
    /// Number of meshes that do not shadow direct light.
    without_shadow: usize,
}

impl MeshGroups {
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut MeshGroup> {
        self.groups.iter_mut().filter(|group| !group.is_empty())
    }

    /// Whether a mesh has this material.
    pub(super) fn uses(&self, material: u32) -> bool {
        self.materials.contains_key(&material)
    }

    /// Whether a mesh does not shadow direct light.
    pub(super) fn has_mesh_without_shadow(&self) -> bool {
        self.without_shadow > 0
    }

    /// Counts a mesh that is in the groups now.
    fn count(&mut self, mesh: &MeshInstance) {
        self.triangles += u64::from(mesh.triangle_count);
        self.without_shadow += usize::from(mesh.flags & MESH_NOT_SHADOW_CASTER != 0);
        *self.materials.entry(mesh.material).or_default() += 1;
    }

    /// Counts a mesh that is not in the groups any more.
    fn uncount(&mut self, mesh: &MeshInstance) {
        self.triangles -= u64::from(mesh.triangle_count);
        self.without_shadow -= usize::from(mesh.flags & MESH_NOT_SHADOW_CASTER != 0);
        if let Some(users) = self.materials.get_mut(&mesh.material) {
            *users -= 1;
            if *users == 0 {
                self.materials.remove(&mesh.material);
            }
        }
    }

    /// Adds a mesh; the bounds in the world of one that is deformed are those of its triangles, too.
    pub(super) fn add(&mut self, mesh: LocatedMesh) -> PlacedMesh {
        self.count(&mesh.instance);
        let group = *self.by_slabs.entry(mesh.slabs).or_insert_with(|| {
            let new = MeshGroup::new(mesh.buffers);
            let empty = self.groups.iter().position(MeshGroup::is_empty);
            match empty {
                Some(place) => self.groups[place] = new,
                None => self.groups.push(new),
            }
            empty.unwrap_or(self.groups.len() - 1)
        });
        let is_deformed = mesh.instance.flags & MESH_SKINNED != 0 || mesh.instance.weight_count > 0;
        let everywhere = (Vec3A::ZERO, Vec3A::INFINITY);
        let bounds = is_deformed.then(|| mesh.bounds.unwrap_or(everywhere));
        PlacedMesh {
            slabs: mesh.slabs,
            mesh: mesh.mesh,
            material: mesh.instance.material,
            levels: mesh.instance.levels,
            bounds: mesh.bounds,
            position: position(&mesh.instance),
            group,
            instance: self.groups[group].add(mesh.instance, bounds),
            hash: mesh.hash,
        }
    }

    fn instance(&self, placed: &PlacedMesh) -> &MeshInstance {
        self.groups[placed.group].instance(placed.instance)
    }

    /// Changes a rigid mesh in place if its triangles stay in the same batches, and returns whether they do. `is_edited`
    /// says whether these are others in the same asset.
    pub(super) fn replace(
        &mut self,
        placed: &mut PlacedMesh,
        mesh: &LocatedMesh,
        is_edited: bool,
    ) -> bool {
        let is_same_mesh = mesh.mesh == placed.mesh && !is_edited;
        let stays = mesh.slabs == placed.slabs
            && self.set(placed, mesh.instance, mesh.bounds, mesh.hash, is_same_mesh);
        if stays {
            placed.mesh = mesh.mesh;
        }
        stays
    }

    /// The same in the same slabs, where the triangles are those of before if it `is_same_mesh`.
    fn set(
        &mut self,
        placed: &mut PlacedMesh,
        instance: MeshInstance,
        bounds: Option<Bounds>,
        hash: u64,
        is_same_mesh: bool,
    ) -> bool {
        let group = &mut self.groups[placed.group];
        let Some(former) = group.replace(placed.instance, instance, is_same_mesh) else {
            return false;
        };
        if (former.material, former.flags) != (instance.material, instance.flags) {
            self.uncount(&former);
            self.count(&instance);
        }
        placed.material = instance.material;
        placed.levels = instance.levels;
        placed.bounds = bounds;
        placed.position = position(&instance);
        placed.hash = hash;
        true
    }

    pub(super) fn remove(&mut self, placed: &PlacedMesh) {
        let group = &mut self.groups[placed.group];
        let removed = group.remove(placed.instance);
        if group.is_empty() {
            // It would keep the slabs' buffers alive.
            *group = MeshGroup::new([const { None }; 3]);
            self.by_slabs.remove(&placed.slabs);
        }
        self.uncount(&removed);
    }
}

/// Meshes that are deformed alike in one place.
#[derive(Clone, Copy, PartialEq)]
struct DeformedMeshes {
    count: usize,
    bounds: Option<Bounds>,
    levels: LevelMask,
    material: u32,
}

/// The move that most meshes have in common.
#[derive(Default)]
struct CommonMove {
    candidate: Vec3,
    /// Number of meshes with this move, less those with others: above 0 for what most have, if anything.
    lead: usize,
}

impl CommonMove {
    /// Greatest difference of equal moves, as a share of them: positions far from the origin are rounded.
    const ROUNDING: f32 = 1e-3;

    fn add(&mut self, by: Vec3) {
        let is_same = by.distance(self.candidate) <= Self::ROUNDING * self.candidate.length();
        if is_same {
            self.lead += 1;
        } else if self.lead == 0 {
            (self.candidate, self.lead) = (by, 1);
        } else {
            self.lead -= 1;
        }
    }

    /// The move if more than half of so many meshes have it, else zero.
    fn of_most(self, meshes: usize) -> Vec3 {
        if self.candidate.is_finite() && 2 * self.lead > meshes {
            self.candidate
        } else {
            Vec3::ZERO
        }
    }
}

/// Collects the meshes that are on the GPU already; the others are added in later frames.
pub(crate) fn collect_mesh_batches(
    mut batches: ResMut<MeshBatches>,
    volume: Res<ExtractedVolume>,
    scene: Res<ExtractedScene>,
    allocator: Res<MeshAllocator>,
    (meshes, assets, notes): (
        Res<RenderAssets<RenderMesh>>,
        Res<ExtractedAssets<RenderMesh>>,
        Res<AssetNotes>,
    ),
    device: Res<RenderDevice>,
) {
    let batches = &mut *batches;
    let Some(volume) = &volume.0 else {
        *batches = MeshBatches::default();
        return;
    };
    let locator = MeshLocator {
        scene: &scene,
        levels: &volume.levels,
        resolution: volume.settings.resolution,
        allocator: &allocator,
        meshes: &meshes,
        notes: &notes,
        most_bytes: device.limits().max_storage_buffer_binding_size,
    };
    let buffers_moved = allocator.meshes_displaced_by_slab_growth().next().is_some();
    let levels = volume.levels.iter().map(|level| (level.center, level.size));
    let is_new = batches.levels.is_empty();
    let has_other_levels = !levels.clone().eq(batches.levels.iter().copied());
    if has_other_levels {
        batches.levels = levels.collect();
    }
    batches.edits += u64::from(batches.has_edits(&locator, &assets));
    if buffers_moved || is_new {
        batches.group_rigid_meshes(&locator);
        batches.changed.everything = true;
    } else {
        let of_now = scene.changed.iter().map(|entity| (*entity, false));
        let mut changed: Vec<_> = of_now.collect();
        if has_other_levels {
            let others = batches.in_other_levels(&locator).into_iter();
            changed.extend(others.map(|entity| (entity, false)));
        }
        if meshes.is_changed() {
            let others = batches.with_other_assets(&locator, &assets).into_iter();
            changed.extend(others.map(|entity| (entity, true)));
        }
        let mut moves = CommonMove::default();
        for (entity, is_edited) in changed {
            let before = batches.placed.get(&entity).map(|placed| placed.position);
            batches.update_rigid_mesh(entity, is_edited, &locator);
            if has_other_levels {
                let after = batches.placed.get(&entity).map(|placed| placed.position);
                moves.add(
                    before
                        .zip(after)
                        .map_or(Vec3::NAN, |(before, after)| after - before),
                );
            }
        }
        batches.world_move = moves.of_most(batches.placed.len());
    }
    // Where most meshes move, everything does.
    batches.changed.everything |= batches.world_move != Vec3::ZERO;
    let deformed_hash = batches.group_deformed_meshes(&locator, &assets);
    batches.fingerprint = FixedHasher.hash_one((batches.rigid_hash, batches.edits, deformed_hash));
    batches.triangles = batches.rigid.triangles + batches.deformed.triangles;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_world_moves_if_most_meshes_do() {
        let most = |moves: &[Vec3], meshes| {
            let mut common = CommonMove::default();
            moves.iter().for_each(|by| common.add(*by));
            common.of_most(meshes)
        };
        let by = Vec3::new(1000.0, 0.0, -300.0);
        let others = [by, by + 0.1, Vec3::X, by, by, Vec3::NAN, by, by];
        assert_eq!(most(&others, 6), by);
        assert_eq!(most(&others, 100), Vec3::ZERO, "most others stay");
        assert_eq!(most(&[Vec3::X, Vec3::Y, by], 3), Vec3::ZERO);
        assert_eq!(most(&[], 0), Vec3::ZERO);
        assert_eq!(most(&[Vec3::NAN; 3], 3), Vec3::ZERO);
    }
}

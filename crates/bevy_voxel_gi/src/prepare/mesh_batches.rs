//! Groups meshes by the GPU buffers that they share, in batches of 64 triangles. The groups are kept from frame to
//! frame, and only what has changed is located anew.

use std::hash::BuildHasher;

use bevy::{
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
    mesh_group::{LevelMask, MeshGroup},
    mesh_instance::MeshLocator,
    voxelization::{Bounds, ChangedRegions},
};
use crate::{
    extract::{
        meshes::{ExtractedScene, SceneMesh},
        place_volume::ExtractedVolume,
    },
    gpu_types::{MESH_NOT_SHADOW_CASTER, MeshInstance},
};

/// The meshes as the voxeliser dispatches them.
#[derive(Resource, Default)]
pub(crate) struct MeshBatches {
    groups: MeshGroups,
    /// Number of meshes in the groups.
    count: usize,
    /// Sum of the hashes of these meshes, which does not depend on their order.
    hash: u64,
    /// Centres and edges of the levels for which the meshes were grouped.
    levels: Vec<(Vec3, f32)>,
    /// Increases when the asset of a mesh that reaches into a level has changed.
    edits: u64,
    /// By how much the world has moved in this frame, as apps move it that keep the origin near the camera: most of the
    /// meshes have moved by it.
    pub world_move: Vec3,
    /// Where meshes have changed since the scene was voxelised last.
    changed: ChangedRegions,
    /// Hash of everything that the voxels depend on.
    pub fingerprint: u64,
}

impl MeshBatches {
    /// Number of triangles of the meshes.
    pub(super) fn triangles(&self) -> u64 {
        self.groups.triangles
    }

    /// Whether a mesh that reaches into a level has this material.
    pub(super) fn uses(&self, material: u32) -> bool {
        self.groups.materials.contains_key(&material)
    }

    /// Whether a mesh that reaches into a level does not shadow direct light.
    pub(super) fn have_mesh_without_shadow(&self) -> bool {
        self.groups.without_shadow > 0
    }

    pub(crate) fn groups_mut(&mut self) -> impl Iterator<Item = &mut MeshGroup> {
        let groups = self.groups.groups.iter_mut();
        groups.filter(|group| !group.is_empty())
    }

    /// Where meshes have changed since this was asked last, or have one of these materials.
    pub(super) fn take_changed(
        &mut self,
        materials: &HashSet<u32>,
        scene: &ExtractedScene,
    ) -> ChangedRegions {
        let mut changed = std::mem::take(&mut self.changed);
        if !materials.is_empty() {
            let placed = scene.meshes.iter().filter_map(|mesh| mesh.placed.as_ref());
            for placed in placed {
                if materials.contains(&self.groups.instance(placed).material) {
                    changed.add(placed.bounds, placed.levels);
                }
            }
        }
        changed
    }

    /// Groups all meshes anew.
    fn group_all(&mut self, scene: &mut ExtractedScene, locator: &MeshLocator) {
        self.groups = MeshGroups::default();
        (self.count, self.hash) = (0, 0);
        self.world_move = Vec3::ZERO;
        scene.meshes.update_all(|mesh, _| {
            mesh.placed = None;
            self.update(mesh, false, locator);
        });
    }

    /// Adds, changes or removes a mesh. `is_edited` says whether its asset may be another one.
    fn update(&mut self, mesh: &mut SceneMesh, is_edited: bool, locator: &MeshLocator) {
        let hash_before = mesh.placed.as_ref().map(|placed| placed.hash);
        if let (Some(now), Some(placed)) = (&mesh.now, &mut mesh.placed)
            && !is_edited
            && now.mesh == placed.mesh
            && let Some((instance, hash)) = locator.moved(now, self.groups.instance(placed))
        {
            if Some(hash) != hash_before {
                self.changed.add(placed.bounds, placed.levels);
                self.changed.add(now.bounds, instance.levels());
            }
            self.hash = self.hash.wrapping_sub(placed.hash).wrapping_add(hash);
            self.groups.set(placed, instance, now.bounds, hash, true);
            return;
        }
        let located = mesh.now.as_ref().and_then(|now| locator.locate(now));
        let hash = located.as_ref().map(|located| located.hash);
        // One that only reaches into other levels was not there, or is not any more.
        let has_changed = is_edited || hash_before.zip(hash).is_some_and(|(a, b)| a != b);
        if has_changed || hash_before.is_some() != hash.is_some() {
            if let Some(placed) = &mesh.placed {
                self.changed.add(placed.bounds, placed.levels);
            }
            if let Some(located) = &located {
                self.changed.add(located.bounds, located.instance.levels());
            }
        }
        self.hash = self.hash.wrapping_sub(hash_before.unwrap_or_default());
        self.hash = self.hash.wrapping_add(hash.unwrap_or_default());
        if let (Some(placed), Some(located)) = (&mut mesh.placed, &located)
            && self.groups.replace(placed, located, is_edited)
        {
            return;
        }
        if let Some(placed) = mesh.placed.take() {
            self.groups.remove(&placed);
            self.count -= 1;
        }
        if let Some(located) = located {
            mesh.placed = Some(self.groups.add(located));
            self.count += 1;
        }
    }

    /// World position of a mesh in the groups.
    fn position(&self, mesh: &SceneMesh) -> Option<Vec3> {
        let instance = self.groups.instance(mesh.placed.as_ref()?);
        Some(instance.world_from_local.w_axis.truncate())
    }

    /// Updates what has changed: meshes, the levels that they reach into, and assets.
    fn update_changed(
        &mut self,
        scene: &mut ExtractedScene,
        locator: &MeshLocator,
        has_other_levels: bool,
        assets: Option<&ExtractedAssets<RenderMesh>>,
    ) {
        self.world_move = Vec3::ZERO;
        if !has_other_levels && assets.is_none() {
            let update = |mesh: &mut SceneMesh| self.update(mesh, false, locator);
            scene.meshes.update_changed(update);
            return;
        }
        let mut moves = CommonMove::default();
        scene.meshes.update_all(|mesh, has_changed| {
            let Some(now) = &mesh.now else {
                self.update(mesh, false, locator);
                return;
            };
            let levels = mesh.placed.as_ref().map_or(0, |placed| placed.levels);
            // The asset of one that is not grouped may be on the GPU now.
            let is_edited = assets.is_some_and(|assets| {
                assets.added.contains(&now.mesh)
                    || locator.meshes.get(now.mesh).is_none()
                    || mesh.placed.is_none()
            });
            let reaches_others = has_other_levels && locator.levels_of(now) != levels;
            if is_edited || reaches_others || has_changed {
                let before = self.position(mesh);
                self.update(mesh, is_edited, locator);
                let by = before.zip(self.position(mesh));
                moves.add(by.map_or(Vec3::NAN, |(before, after)| after - before));
            }
        });
        if has_other_levels {
            self.world_move = moves.of_most(self.count);
        }
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
pub(crate) struct PlacedMesh {
    group: usize,
    instance: usize,
    levels: LevelMask,
    hash: u64,
    bounds: Option<Bounds>,
    mesh: AssetId<Mesh>,
    slabs: Slabs,
}

/// Groups by their slabs.
#[derive(Default)]
struct MeshGroups {
    /// A group without a mesh is replaced by the next new one.
    groups: Vec<MeshGroup>,
    by_slabs: HashMap<Slabs, usize>,
    /// Number of triangles of all meshes.
    triangles: u64,
    materials: HashMap<u32, usize>,
    without_shadow: usize,
}

impl MeshGroups {
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

    fn add(&mut self, mesh: LocatedMesh) -> PlacedMesh {
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
        PlacedMesh {
            group,
            instance: self.groups[group].add(mesh.instance, mesh.bounds),
            levels: mesh.instance.levels(),
            hash: mesh.hash,
            bounds: mesh.bounds,
            mesh: mesh.mesh,
            slabs: mesh.slabs,
        }
    }

    fn instance(&self, placed: &PlacedMesh) -> &MeshInstance {
        self.groups[placed.group].instance(placed.instance)
    }

    /// Changes a mesh in place if its triangles stay in the same batches, and returns whether they do. `is_edited`
    /// says whether these are others in the same asset.
    fn replace(&mut self, placed: &mut PlacedMesh, mesh: &LocatedMesh, is_edited: bool) -> bool {
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
        let Some(former) = group.replace(placed.instance, instance, bounds, is_same_mesh) else {
            return false;
        };
        if (former.material, former.flags) != (instance.material, instance.flags) {
            self.uncount(&former);
            self.count(&instance);
        }
        placed.levels = instance.levels();
        placed.bounds = bounds;
        placed.hash = hash;
        true
    }

    fn remove(&mut self, placed: &PlacedMesh) {
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

/// Whether the asset of a mesh that reaches into a level is another one than in the last frame.
fn have_edits(
    scene: &ExtractedScene,
    locator: &MeshLocator,
    assets: &ExtractedAssets<RenderMesh>,
) -> bool {
    let mut meshes = scene.meshes.iter().filter_map(|mesh| mesh.now.as_ref());
    !assets.added.is_empty()
        && meshes.any(|mesh| assets.added.contains(&mesh.mesh) && locator.levels_of(mesh) != 0)
}

/// Collects the meshes that are on the GPU already; the others are added in later frames.
pub(crate) fn collect_mesh_batches(
    mut batches: ResMut<MeshBatches>,
    volume: Res<ExtractedVolume>,
    mut scene: ResMut<ExtractedScene>,
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
    batches.edits += u64::from(have_edits(&scene, &locator, &assets));
    if buffers_moved || is_new {
        batches.group_all(&mut scene, &locator);
        batches.changed.everything = true;
    } else {
        let assets = meshes.is_changed().then_some(&*assets);
        batches.update_changed(&mut scene, &locator, has_other_levels, assets);
    }
    // Where most meshes move, everything does.
    batches.changed.everything |= batches.world_move != Vec3::ZERO;
    batches.fingerprint = FixedHasher.hash_one((batches.hash, batches.edits));
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

//! Groups meshes by the GPU buffers that they share, in batches of 64 triangles. Groups of rigid meshes are kept
//! from frame to frame: a mesh that moves within its levels is changed in place.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    ecs::entity::EntityHashMap,
    platform::{collections::HashMap, hash::FixedHasher},
    prelude::*,
    render::{
        mesh::{
            RenderMesh,
            allocator::{MeshAllocator, MeshSlabId},
        },
        render_asset::RenderAssets,
        render_resource::{Buffer, BufferUsages},
        renderer::RenderDevice,
    },
};

use super::{fingerprint::hash_floats, mesh_group::MeshGroup, mesh_instance::mesh_instance};
use crate::{
    extract::{
        meshes::{ExtractedMesh, ExtractedScene},
        placement::PlacedLevel,
        volume::ExtractedVolume,
    },
    gpu_types::{MAX_LEVELS, MeshInstance},
};

/// The meshes as the voxeliser dispatches them.
#[derive(Resource, Default)]
pub(crate) struct MeshBatches {
    rigid: MeshGroups,
    deformed: MeshGroups,
    /// The rigid meshes in `rigid`.
    placed: EntityHashMap<PlacedMesh>,
    /// Sum of the hashes of the rigid meshes, which does not depend on their order.
    rigid_hash: u64,
    /// Centres and edges of the levels for which the rigid meshes were grouped.
    levels: Vec<(Vec3, f32)>,
    /// Hash of everything that the voxels depend on.
    pub fingerprint: u64,
    pub triangles: u64,
}

impl MeshBatches {
    pub(crate) fn groups_mut(&mut self) -> impl Iterator<Item = &mut MeshGroup> {
        let groups = self.rigid.groups.iter_mut();
        groups.chain(&mut self.deformed.groups)
    }
}

/// The place of a rigid mesh in the groups.
struct PlacedMesh {
    slabs: Slabs,
    levels: LevelMask,
    group: usize,
    instance: usize,
    hash: u64,
}

/// The slabs of vertices, indices and morph targets.
type Slabs = [Option<MeshSlabId>; 3];

/// A bit for each level that a mesh may reach into.
type LevelMask = u32;
const _: () = assert!(MAX_LEVELS <= LevelMask::BITS as usize);

/// Groups by their slabs.
#[derive(Default)]
struct MeshGroups {
    groups: Vec<MeshGroup>,
    by_slabs: HashMap<Slabs, usize>,
    triangles: u64,
}

impl MeshGroups {
    /// Returns the places of the group and of the instance in it.
    fn add(&mut self, mesh: LocatedMesh) -> (usize, usize) {
        self.triangles += u64::from(mesh.instance.triangle_count);
        let group = *self.by_slabs.entry(mesh.slabs).or_insert_with(|| {
            self.groups.push(MeshGroup::new(mesh.buffers));
            self.groups.len() - 1
        });
        (group, self.groups[group].add(mesh.instance, mesh.levels))
    }
}

/// A mesh that is on the GPU and reaches into a level.
struct LocatedMesh {
    slabs: Slabs,
    /// The buffers of the slabs.
    buffers: [Option<Buffer>; 3],
    instance: MeshInstance,
    levels: LevelMask,
    hash: u64,
}

/// The resources by which a mesh is located on the GPU.
struct Locator<'a> {
    scene: &'a ExtractedScene,
    levels: &'a [PlacedLevel],
    allocator: &'a MeshAllocator,
    meshes: &'a RenderAssets<RenderMesh>,
    /// Size of the largest buffer that a shader can read.
    most_bytes: u64,
}

impl Locator<'_> {
    /// Returns `None` if the mesh reaches into no level, or is not on the GPU yet.
    fn locate(&self, extracted: &ExtractedMesh) -> Option<LocatedMesh> {
        let reached = self.levels.iter().map(|level| extracted.reaches(level));
        let reached = (0..).zip(reached).filter(|(_, reached)| *reached);
        let levels = reached.fold(0, |mask, (level, _): (u32, _)| mask | 1 << level);
        if levels == 0 {
            return None;
        }
        let mesh = self.meshes.get(extracted.mesh)?;
        let slabs = self.allocator.mesh_slabs(&extracted.mesh)?;
        let mut instance = mesh_instance(extracted, mesh, &self.scene.materials)?;
        let vertices = self.allocator.mesh_vertex_slice(&extracted.mesh)?;
        let indices = self.allocator.mesh_index_slice(&extracted.mesh);
        instance.vertex_base = vertices.range.start * instance.vertex_stride;
        instance.index_base = indices.as_ref().map_or(0, |slice| slice.range.start);
        // Words per vertex of a target: displacements of position, normal and tangent, 16 bytes each.
        const MORPH_WORDS: u32 = 12;
        let targets = extracted.weights.and_then(|_| {
            let targets = self.allocator.mesh_morph_target_slice(&extracted.mesh);
            targets.zip(slabs.morph_target_slab_id)
        });
        match &targets {
            Some((slice, _)) => instance.morph_base = slice.range.start * MORPH_WORDS,
            None => instance.weight_count = 0,
        }
        let buffers = [
            Some(vertices.buffer),
            indices.as_ref().map(|slice| slice.buffer),
            targets.as_ref().map(|(slice, _)| slice.buffer),
        ];
        let usable = |buffer: &&Buffer| {
            buffer.usage().contains(BufferUsages::STORAGE) && buffer.size() <= self.most_bytes
        };
        if !buffers.iter().flatten().all(usable) {
            warn_once!(
                "voxel GI: a mesh is in a buffer that shaders cannot read on this adapter (larger \
                 than {} bytes, or allocated on its own); it is not voxelised. Split such meshes",
                self.most_bytes
            );
            return None;
        }
        Some(LocatedMesh {
            slabs: [
                Some(slabs.vertex_slab_id),
                slabs.index_slab_id,
                targets.map(|(_, slab)| slab),
            ],
            buffers: buffers.map(|buffer| buffer.cloned()),
            hash: mesh_hash(extracted, &instance),
            instance,
            levels,
        })
    }
}

fn mesh_hash(extracted: &ExtractedMesh, instance: &MeshInstance) -> u64 {
    let mut hasher = FixedHasher.build_hasher();
    extracted.mesh.hash(&mut hasher);
    hash_floats(&mut hasher, &instance.world_from_local.to_cols_array());
    (instance.material, instance.flags, instance.triangle_count).hash(&mut hasher);
    (instance.first_weights, instance.weight_count).hash(&mut hasher);
    hash_floats(&mut hasher, &[instance.coverage]);
    hasher.finish()
}

impl MeshBatches {
    /// Groups all rigid meshes anew.
    fn group_rigid_meshes(&mut self, locator: &Locator) {
        self.rigid = MeshGroups::default();
        self.placed.clear();
        self.rigid_hash = 0;
        for (&entity, extracted) in &locator.scene.rigid {
            let Some(mesh) = locator.locate(extracted) else {
                continue;
            };
            let (slabs, levels, hash) = (mesh.slabs, mesh.levels, mesh.hash);
            let (group, instance) = self.rigid.add(mesh);
            self.rigid_hash = self.rigid_hash.wrapping_add(hash);
            let placed = PlacedMesh {
                slabs,
                levels,
                group,
                instance,
                hash,
            };
            self.placed.insert(entity, placed);
        }
    }

    /// Changes a rigid mesh in place, and returns whether that is possible: its triangles are in the same batches.
    fn update_rigid_mesh(&mut self, entity: Entity, locator: &Locator) -> bool {
        let extracted = locator.scene.rigid.get(&entity);
        let mesh = extracted.and_then(|extracted| locator.locate(extracted));
        let (mesh, placed) = match (mesh, self.placed.get_mut(&entity)) {
            (Some(mesh), Some(placed)) => (mesh, placed),
            (mesh, placed) => return mesh.is_none() && placed.is_none(),
        };
        let group = &mut self.rigid.groups[placed.group];
        if (mesh.slabs, mesh.levels) != (placed.slabs, placed.levels)
            || !group.replace(placed.instance, mesh.instance)
        {
            return false;
        }
        let without = self.rigid_hash.wrapping_sub(placed.hash);
        self.rigid_hash = without.wrapping_add(mesh.hash);
        placed.hash = mesh.hash;
        true
    }
}

/// Collects the meshes that are on the GPU already; the others are added in later frames.
pub(crate) fn collect_mesh_batches(
    mut batches: ResMut<MeshBatches>,
    volume: Res<ExtractedVolume>,
    scene: Res<ExtractedScene>,
    allocator: Res<MeshAllocator>,
    meshes: Res<RenderAssets<RenderMesh>>,
    device: Res<RenderDevice>,
) {
    let batches = &mut *batches;
    let Some(volume) = &volume.0 else {
        *batches = MeshBatches::default();
        return;
    };
    let locator = Locator {
        scene: &scene,
        levels: &volume.levels,
        allocator: &allocator,
        meshes: &meshes,
        most_bytes: device.limits().max_storage_buffer_binding_size,
    };
    let levels = volume.levels.iter().map(|level| (level.center, level.size));
    let levels: Vec<_> = levels.collect();
    let buffers_moved =
        meshes.is_changed() || allocator.meshes_displaced_by_slab_growth().next().is_some();
    let in_place = batches.levels == levels && !buffers_moved;
    let changed = scene.changed.as_ref().filter(|_| in_place);
    let mut entities = changed.into_iter().flatten();
    if changed.is_none() || !entities.all(|entity| batches.update_rigid_mesh(*entity, &locator)) {
        batches.group_rigid_meshes(&locator);
        batches.levels = levels;
    }
    let mut hasher = FixedHasher.build_hasher();
    batches.deformed = MeshGroups::default();
    for mesh in scene
        .deformed
        .iter()
        .filter_map(|mesh| locator.locate(mesh))
    {
        mesh.hash.hash(&mut hasher);
        batches.deformed.add(mesh);
    }
    for joint in &scene.joints {
        hash_floats(&mut hasher, &joint.to_cols_array());
    }
    (batches.rigid_hash, scene.mesh_edits).hash(&mut hasher);
    batches.fingerprint = hasher.finish();
    batches.triangles = batches.rigid.triangles + batches.deformed.triangles;
}

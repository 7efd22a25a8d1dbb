//! Finds meshes in the GPU's buffers and in the levels.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    platform::hash::FixedHasher,
    prelude::*,
    render::{
        mesh::{RenderMesh, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_resource::{Buffer, BufferUsages},
    },
};

use super::{
    asset_notes::AssetNotes, fingerprint::hash_floats, mesh_group::LevelMask,
    mesh_groups::LocatedMesh, mesh_instance::mesh_instance,
};
use crate::{
    extract::{
        meshes::{ExtractedMesh, ExtractedScene},
        placement::PlacedLevel,
    },
    gpu_types::{MAX_LEVELS, MeshInstance},
};

const _: () = assert!(MAX_LEVELS <= LevelMask::BITS as usize);

/// The resources by which a mesh is located.
pub(super) struct MeshLocator<'a> {
    pub scene: &'a ExtractedScene,
    pub levels: &'a [PlacedLevel],
    pub resolution: u32,
    pub allocator: &'a MeshAllocator,
    pub meshes: &'a RenderAssets<RenderMesh>,
    pub notes: &'a AssetNotes,
    /// Size of the largest buffer that a shader can read.
    pub most_bytes: u64,
}

impl MeshLocator<'_> {
    /// The levels that a mesh may reach into.
    pub(super) fn levels_of(&self, extracted: &ExtractedMesh) -> LevelMask {
        let reaches = |level: &PlacedLevel| {
            let sub_voxel = level.size / (4.0 * self.resolution as f32);
            extracted.reaches(level) && (!level.is_outer || extracted.is_landscape(sub_voxel))
        };
        let reached = self.levels.iter().map(reaches);
        let reached = (0..).zip(reached).filter(|(_, reached)| *reached);
        reached.fold(0, |mask, (level, _): (u32, _)| mask | 1 << level)
    }

    /// Returns `None` if the mesh reaches into no level, or is not on the GPU yet.
    pub(super) fn locate(&self, extracted: &ExtractedMesh) -> Option<LocatedMesh> {
        let levels = self.levels_of(extracted);
        if levels == 0 {
            return None;
        }
        let mesh = self.meshes.get(extracted.mesh)?;
        let slabs = self.allocator.mesh_slabs(&extracted.mesh)?;
        let mut instance =
            mesh_instance(extracted, mesh, self.notes.packed_ranges(extracted.mesh))?;
        let vertices = self.allocator.mesh_vertex_slice(&extracted.mesh)?;
        let indices = self.allocator.mesh_index_slice(&extracted.mesh);
        instance.levels = levels;
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
            mesh: extracted.mesh,
            bounds: extracted.bounds,
            hash: mesh_hash(extracted, &instance),
            instance,
        })
    }
}

fn mesh_hash(extracted: &ExtractedMesh, instance: &MeshInstance) -> u64 {
    let mut hasher = FixedHasher.build_hasher();
    extracted.mesh.hash(&mut hasher);
    hash_floats(&mut hasher, &instance.world_from_local.to_cols_array());
    (instance.material, instance.flags, instance.triangle_count).hash(&mut hasher);
    instance.weight_count.hash(&mut hasher);
    // Those of an edited mesh may come later than its triangles.
    for corner in extracted
        .bounds
        .iter()
        .flat_map(|bounds| [bounds.0, bounds.1])
    {
        hash_floats(&mut hasher, &corner.to_array());
    }
    hasher.finish()
}

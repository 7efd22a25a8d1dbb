//! Finds a mesh in the levels and in the GPU's buffers, and describes it as the voxelisers read it.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    platform::hash::FixedHasher,
    prelude::*,
    render::{
        mesh::{RenderMesh, RenderMeshBufferInfo, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_resource::{Buffer, BufferUsages, IndexFormat},
    },
};

use super::{
    asset_notes::{AssetNotes, PackedRanges},
    materials::flag,
    mesh_batches::LocatedMesh,
    mesh_group::LevelMask,
    plan::hash_floats,
};
use crate::{
    extract::{meshes::ExtractedMesh, placement::PlacedLevel},
    gpu_types::{
        COLORS_FLOAT16, COLORS_FLOAT32, COLORS_UNORM8, COLORS_UNORM16, MAX_LEVELS, MESH_COLORS,
        MESH_LEVELS_SHIFT, MESH_MIRRORED, MESH_NOT_SHADOW_CASTER, MESH_PACKED_JOINT_WEIGHTS,
        MESH_PACKED_POSITIONS, MESH_PACKED_UVS, MESH_SKINNED, MESH_STRIP, MESH_UVS, MeshInstance,
    },
};

/// The bits of the flags that are levels.
const LEVELS: u32 = LevelMask::MAX << MESH_LEVELS_SHIFT;
const _: () = assert!(MAX_LEVELS <= 16);

/// The resources by which a mesh is located.
pub(super) struct MeshLocator<'a> {
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

    /// A mesh that has moved, has another pose or another material, and its hash: all else is as it was. `None` if it
    /// reaches into no level, or is deformed by other means.
    pub(super) fn moved(
        &self,
        extracted: &ExtractedMesh,
        former: &MeshInstance,
    ) -> Option<(MeshInstance, u64)> {
        const OF_ASSET: u32 = !(MESH_MIRRORED | MESH_NOT_SHADOW_CASTER | LEVELS);
        let levels = self.levels_of(extracted);
        let is_skinned = former.flags & MESH_SKINNED != 0;
        let (first_weights, weight_count) = extracted.weights.unwrap_or_default();
        let instance = MeshInstance {
            world_from_local: extracted.world_from_local.into(),
            material: extracted.material,
            flags: former.flags & OF_ASSET
                | placement_flags(extracted, is_skinned)
                | levels << MESH_LEVELS_SHIFT,
            first_joint: extracted.first_joint.unwrap_or_default(),
            first_weights,
            ..*former
        };
        let is_known = is_skinned == extracted.first_joint.is_some()
            && weight_count == former.weight_count
            && levels != 0;
        is_known.then(|| (instance, mesh_hash(extracted, &instance)))
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
        instance.flags |= levels << MESH_LEVELS_SHIFT;
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
    let flags = instance.flags & !LEVELS;
    (instance.material, flags, instance.triangle_count).hash(&mut hasher);
    (instance.weight_count, extracted.pose).hash(&mut hasher);
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

/// What of the flags does not depend on the asset.
fn placement_flags(extracted: &ExtractedMesh, is_skinned: bool) -> u32 {
    let is_mirrored = !is_skinned && extracted.world_from_local.matrix3.determinant() < 0.0;
    flag(is_mirrored, MESH_MIRRORED) | flag(!extracted.casts_shadow, MESH_NOT_SHADOW_CASTER)
}

/// The instance without the base offsets of its buffers; `None` if it has no triangles that can be read.
fn mesh_instance(
    extracted: &ExtractedMesh,
    mesh: &RenderMesh,
    ranges: PackedRanges,
) -> Option<MeshInstance> {
    let (corners, index_size) = match &mesh.buffer_info {
        RenderMeshBufferInfo::Indexed {
            count,
            index_format,
        } => (
            *count,
            match index_format {
                IndexFormat::Uint16 => 2,
                IndexFormat::Uint32 => 4,
            },
        ),
        RenderMeshBufferInfo::NonIndexed => (mesh.vertex_count, 0),
    };
    let (triangle_count, strip) = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => (corners / 3, 0),
        PrimitiveTopology::TriangleStrip => (corners.saturating_sub(2), MESH_STRIP),
        _ => return None,
    };
    let layout = mesh.layout.0.layout();
    // Offset of an attribute in words, and its format.
    let attribute = |attribute: MeshVertexAttribute| {
        let ids = mesh.layout.0.attribute_ids();
        let index = ids.iter().position(|id| *id == attribute.id)?;
        let attribute = layout.attributes.get(index)?;
        Some(((attribute.offset / 4) as u32, attribute.format))
    };
    let mut flags = strip;
    let position_offset = match attribute(Mesh::ATTRIBUTE_POSITION) {
        Some((offset, VertexFormat::Float32x3)) => offset,
        Some((offset, VertexFormat::Snorm16x4)) => {
            flags |= MESH_PACKED_POSITIONS;
            offset
        }
        other => {
            warn_once!(
                "voxel GI: the positions of a mesh have the format {:?}, so it is not voxelised. Use {:?}, or Bevy's \
                 compressed positions",
                other.map(|(_, format)| format),
                VertexFormat::Float32x3
            );
            return None;
        }
    };
    let mut uv_offsets = UVec2::ZERO;
    let uvs = [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_UV_1];
    for (channel, uv) in uvs.into_iter().enumerate() {
        let packed = match attribute(uv) {
            Some((offset, format @ (VertexFormat::Float32x2 | VertexFormat::Unorm16x2))) => {
                uv_offsets[channel] = offset;
                format == VertexFormat::Unorm16x2
            }
            _ => continue,
        };
        flags |= MESH_UVS << channel | flag(packed, MESH_PACKED_UVS << channel);
    }
    let mut color_offset = 0;
    if let Some((offset, format)) = attribute(Mesh::ATTRIBUTE_COLOR) {
        let format = match format {
            VertexFormat::Float32x4 => Some(COLORS_FLOAT32),
            VertexFormat::Unorm8x4 => Some(COLORS_UNORM8),
            VertexFormat::Float16x4 => Some(COLORS_FLOAT16),
            VertexFormat::Unorm16x4 => Some(COLORS_UNORM16),
            other => {
                warn_once!(
                    "voxel GI: vertex colours of the format {other:?} count as white. Use `Float32x4`, `Float16x4`, \
                     `Unorm8x4` or `Unorm16x4`"
                );
                None
            }
        };
        if let Some(format) = format {
            color_offset = offset;
            flags |= MESH_COLORS | format;
        }
    }
    let skin = extracted.first_joint.and_then(|first| {
        let (joints, VertexFormat::Uint16x4) = attribute(Mesh::ATTRIBUTE_JOINT_INDEX)? else {
            return None;
        };
        let weights = match attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT)? {
            (offset, VertexFormat::Float32x4) => offset,
            (offset, VertexFormat::Unorm16x4) => {
                flags |= MESH_PACKED_JOINT_WEIGHTS;
                offset
            }
            _ => return None,
        };
        Some((first, joints, weights))
    });
    if extracted.first_joint.is_some() && skin.is_none() {
        warn_once!(
            "voxel GI: a skinned mesh's joints are not {:?}, or its weights not {:?} or {:?}; it is voxelised \
             without skinning",
            VertexFormat::Uint16x4,
            VertexFormat::Float32x4,
            VertexFormat::Unorm16x4
        );
    }
    flags |= placement_flags(extracted, skin.is_some()) | flag(skin.is_some(), MESH_SKINNED);
    let (first_weights, weight_count) = extracted.weights.unwrap_or_default();
    let (first_joint, joint_index_offset, joint_weight_offset) = skin.unwrap_or_default();
    Some(MeshInstance {
        world_from_local: extracted.world_from_local.into(),
        uv_range_0: ranges.uvs[0],
        uv_range_1: ranges.uvs[1],
        position_center: ranges.position_center,
        position_half_size: ranges.position_half_size,
        uv_offsets,
        color_offset,
        vertex_base: 0,
        vertex_stride: (layout.array_stride / 4) as u32,
        position_offset,
        joint_index_offset,
        joint_weight_offset,
        first_joint,
        index_base: 0,
        index_size,
        triangle_count,
        material: extracted.material,
        flags,
        morph_base: 0,
        vertex_count: mesh.vertex_count,
        first_weights,
        weight_count,
    })
}

//! The instance of a mesh, which the voxelisers read.

use bevy::{
    mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    prelude::*,
    render::{
        mesh::{RenderMesh, RenderMeshBufferInfo},
        render_resource::IndexFormat,
    },
};

use super::asset_notes::PackedRanges;
use crate::{
    extract::meshes::ExtractedMesh,
    gpu_types::{
        COLORS_FLOAT16, COLORS_FLOAT32, COLORS_UNORM8, COLORS_UNORM16, MESH_COLORS, MESH_MIRRORED,
        MESH_NOT_SHADOW_CASTER, MESH_PACKED_JOINT_WEIGHTS, MESH_PACKED_POSITIONS, MESH_PACKED_UVS,
        MESH_SKINNED, MESH_STRIP, MESH_UVS, MeshInstance,
    },
};

/// The instance without the base offsets of its buffers; `None` if it has no triangles that can be read.
pub(super) fn mesh_instance(
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
        flags |= MESH_UVS << channel;
        if packed {
            flags |= MESH_PACKED_UVS << channel;
        }
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
    if skin.is_some() {
        flags |= MESH_SKINNED;
    } else if extracted.world_from_local.matrix3.determinant() < 0.0 {
        flags |= MESH_MIRRORED;
    }
    if !extracted.casts_shadow {
        flags |= MESH_NOT_SHADOW_CASTER;
    }
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
        levels: 0,
    })
}

//! The instance of a mesh, which the voxelisers read.

use bevy::{
    mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    prelude::*,
    render::{
        mesh::{RenderMesh, RenderMeshBufferInfo},
        render_resource::IndexFormat,
    },
};

use crate::{
    extract::{meshes::ExtractedMesh, voxel_material::VoxelMaterial},
    gpu_types::{
        MESH_DOUBLE_SIDED, MESH_MIRRORED, MESH_NOT_SHADOW_CASTER, MESH_SKINNED, MESH_STRIP,
        MeshInstance,
    },
};

/// The instance without the base offsets of its buffers; `None` if it has no triangles that can be read.
pub(super) fn mesh_instance(
    extracted: &ExtractedMesh,
    mesh: &RenderMesh,
    materials: &[VoxelMaterial],
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
    // Offset of an attribute in words, if it has this format.
    let offset = |attribute: MeshVertexAttribute| {
        let index = mesh
            .layout
            .0
            .attribute_ids()
            .iter()
            .position(|id| *id == attribute.id)?;
        let attribute_layout = layout.attributes.get(index)?;
        (attribute_layout.format == attribute.format)
            .then_some((attribute_layout.offset / 4) as u32)
    };
    let Some(position_offset) = offset(Mesh::ATTRIBUTE_POSITION) else {
        warn_once!(
            "voxel GI: a mesh's positions are not {:?}; it is not voxelised. Do not compress its \
             positions (`MeshAttributeCompressionFlags::COMPRESS_POSITION`)",
            VertexFormat::Float32x3
        );
        return None;
    };
    let skin = extracted.first_joint.and_then(|first| {
        Some((
            first,
            offset(Mesh::ATTRIBUTE_JOINT_INDEX)?,
            offset(Mesh::ATTRIBUTE_JOINT_WEIGHT)?,
        ))
    });
    if extracted.first_joint.is_some() && skin.is_none() {
        warn_once!(
            "voxel GI: a skinned mesh's joints and weights are not {:?} and {:?}; it is voxelised \
             without skinning. Do not quantise its weights (`MeshCompressionArgs`)",
            VertexFormat::Uint16x4,
            VertexFormat::Float32x4
        );
    }
    let material = materials.get(extracted.material as usize);
    let mut flags = strip;
    if skin.is_some() {
        flags |= MESH_SKINNED;
    } else if extracted.world_from_local.matrix3.determinant() < 0.0 {
        flags |= MESH_MIRRORED;
    }
    if material.is_some_and(|material| material.double_sided == 1) {
        flags |= MESH_DOUBLE_SIDED;
    }
    if !extracted.casts_shadow {
        flags |= MESH_NOT_SHADOW_CASTER;
    }
    let (first_weights, weight_count) = extracted.weights.unwrap_or_default();
    let (first_joint, joint_index_offset, joint_weight_offset) = skin.unwrap_or_default();
    Some(MeshInstance {
        world_from_local: extracted.world_from_local.into(),
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
        coverage: material.map_or(1.0, |material| marked_fraction(material.coverage)),
        morph_base: 0,
        vertex_count: mesh.vertex_count,
        first_weights,
        weight_count,
    })
}

/// Effective number of sub-voxels that can stop a ray in one layer of them, as they are as thick as they
/// are wide: the mean over directions, measured such that masks with a coverage of a half and a quarter
/// transmit half and three quarters of the light.
const CELLS_IN_LAYER: f32 = 1.85;

/// Fraction of sub-voxels to mark so that a surface transmits as much light, averaged over directions,
/// as its coverage says.
fn marked_fraction(coverage: f32) -> f32 {
    1.0 - (1.0 - coverage.clamp(0.0, 1.0)).powf(CELLS_IN_LAYER.recip())
}

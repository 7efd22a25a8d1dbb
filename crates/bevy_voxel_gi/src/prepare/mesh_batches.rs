//! Groups meshes by the GPU buffers that they share, in batches of 64 triangles.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    platform::{collections::HashMap, hash::FixedHasher},
    prelude::*,
    render::{
        mesh::{
            RenderMesh, RenderMeshBufferInfo,
            allocator::{MeshAllocator, MeshSlabId},
        },
        render_asset::RenderAssets,
        render_resource::{Buffer, BufferUsages, IndexFormat},
        renderer::RenderDevice,
    },
};

use super::fingerprint::hash_floats;
use crate::{
    extract::{
        meshes::{ExtractedMesh, ExtractedScene},
        volume::ExtractedVolume,
    },
    gpu_types::{
        MESH_DOUBLE_SIDED, MESH_MIRRORED, MESH_SKINNED, MESH_STRIP, MeshInstance, TriangleBatch,
    },
};

/// Number of triangles in a batch.
const BATCH_TRIANGLES: u32 = 64;

/// Meshes that share their buffers.
pub(crate) struct MeshGroup {
    pub vertices: Buffer,
    /// `None` if the meshes are not indexed.
    pub indices: Option<Buffer>,
    /// `None` if the meshes have no morph targets.
    pub morph_targets: Option<Buffer>,
    pub instances: Vec<MeshInstance>,
    pub batches: Vec<TriangleBatch>,
}

/// The meshes as the voxeliser dispatches them.
#[derive(Resource, Default)]
pub(crate) struct MeshBatches {
    pub groups: Vec<MeshGroup>,
    /// Hash of everything that the voxels depend on.
    pub fingerprint: u64,
    pub triangles: u64,
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
    let Some(volume) = &volume.0 else {
        batches.groups.clear();
        return;
    };
    let mut groups = HashMap::<[Option<MeshSlabId>; 3], MeshGroup>::default();
    let mut hasher = FixedHasher.build_hasher();
    let mut triangles = 0;
    let most_bytes = device.limits().max_storage_buffer_binding_size;
    for extracted in &scene.meshes {
        let (Some(mesh), Some(slabs)) = (
            meshes.get(extracted.mesh),
            allocator.mesh_slabs(&extracted.mesh),
        ) else {
            continue;
        };
        let Some(mut instance) = mesh_instance(extracted, mesh, &scene) else {
            continue;
        };
        let Some(vertices) = allocator.mesh_vertex_slice(&extracted.mesh) else {
            continue;
        };
        let indices = allocator.mesh_index_slice(&extracted.mesh);
        instance.vertex_base = vertices.range.start * instance.vertex_stride;
        instance.index_base = indices.as_ref().map_or(0, |slice| slice.range.start);
        // Words per vertex of a target: displacements of position, normal and tangent, 16 bytes each.
        const MORPH_WORDS: u32 = 12;
        let targets = allocator.mesh_morph_target_slice(&extracted.mesh);
        match &targets {
            Some(slice) => instance.morph_base = slice.range.start * MORPH_WORDS,
            None => instance.weight_count = 0,
        }
        let usable = |buffer: &Buffer| {
            buffer.usage().contains(BufferUsages::STORAGE) && buffer.size() <= most_bytes
        };
        let others = [&indices, &targets];
        let mut others = others.into_iter().flatten();
        if !usable(vertices.buffer) || !others.all(|slice| usable(slice.buffer)) {
            warn_once!(
                "voxel GI: a mesh is in a buffer that shaders cannot read on this adapter (larger \
                 than {most_bytes} bytes, or allocated on its own); it is not voxelised. Split \
                 such meshes"
            );
            continue;
        }
        hash_mesh(&mut hasher, extracted, &instance);
        triangles += u64::from(instance.triangle_count);
        let group = groups
            .entry([
                Some(slabs.vertex_slab_id),
                slabs.index_slab_id,
                slabs.morph_target_slab_id,
            ])
            .or_insert_with(|| MeshGroup {
                vertices: vertices.buffer.clone(),
                indices: indices.as_ref().map(|slice| slice.buffer.clone()),
                morph_targets: targets.as_ref().map(|slice| slice.buffer.clone()),
                instances: Vec::new(),
                batches: Vec::new(),
            });
        let index = u32::try_from(group.instances.len()).unwrap_or(u32::MAX);
        for (level, _) in (0..)
            .zip(&volume.levels)
            .filter(|(_, l)| extracted.reaches(l))
        {
            group.batches.extend(
                (0..instance.triangle_count)
                    .step_by(BATCH_TRIANGLES as usize)
                    .map(|first_triangle| TriangleBatch {
                        instance: index,
                        first_triangle,
                        level,
                        pad: 0,
                    }),
            );
        }
        group.instances.push(instance);
    }
    for joint in &scene.joints {
        hash_floats(&mut hasher, &joint.to_cols_array());
    }
    scene.mesh_edits.hash(&mut hasher);
    *batches = MeshBatches {
        groups: groups
            .into_values()
            .filter(|group| !group.batches.is_empty())
            .collect(),
        fingerprint: hasher.finish(),
        triangles,
    };
}

/// The instance without the base offsets of its buffers; `None` if it has no triangles that can be read.
fn mesh_instance(
    extracted: &ExtractedMesh,
    mesh: &RenderMesh,
    scene: &ExtractedScene,
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
    let material = scene.materials.get(extracted.material as usize);
    let mut flags = strip;
    if skin.is_some() {
        flags |= MESH_SKINNED;
    } else if extracted.world_from_local.matrix3.determinant() < 0.0 {
        flags |= MESH_MIRRORED;
    }
    if material.is_some_and(|material| material.double_sided == 1) {
        flags |= MESH_DOUBLE_SIDED;
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

fn hash_mesh(hasher: &mut impl Hasher, extracted: &ExtractedMesh, instance: &MeshInstance) {
    extracted.mesh.hash(hasher);
    hash_floats(hasher, &instance.world_from_local.to_cols_array());
    (instance.material, instance.flags, instance.triangle_count).hash(hasher);
    (instance.first_weights, instance.weight_count).hash(hasher);
    hash_floats(hasher, &[instance.coverage]);
}

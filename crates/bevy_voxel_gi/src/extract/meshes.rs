//! Extracts the meshes, including those outside of every view, which Bevy's own extraction leaves out.

use bevy::{
    camera::primitives::Aabb,
    math::{Affine3A, Vec3A},
    mesh::{
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    render::Extract,
};

use super::{
    material_order::sorted_by_value,
    material_table::{MaterialIndex, MaterialTable},
    place_volume::ActiveVolume,
    placement::PlacedLevel,
    voxel_material::VoxelMaterial,
};
use crate::settings::{NotVoxelized, VoxelAlbedo};

/// A mesh in the volume.
#[derive(Clone, Copy, Debug)]
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
    pub meshes: Vec<ExtractedMesh>,
    /// Matrices from bind pose to world, of all skins; then weights of morph targets, 16 in each.
    pub joints: Vec<Mat4>,
    /// The materials in use, sorted; see [`sorted_by_value`].
    pub materials: Vec<VoxelMaterial>,
    /// Index into `materials` for each entry of the unsorted table.
    indices: Vec<u32>,
    /// Version of the unsorted table, and whether all albedo is neutral.
    version: Option<(u64, bool)>,
    /// Increases when a mesh asset changes.
    pub mesh_edits: u64,
}

pub(crate) fn extract_scene(
    mut scene: ResMut<ExtractedScene>,
    active: Extract<Res<ActiveVolume>>,
    table: Extract<Res<MaterialTable>>,
    mut mesh_events: Extract<MessageReader<AssetEvent<Mesh>>>,
    meshes: Extract<
        Query<
            (
                &Mesh3d,
                &GlobalTransform,
                &InheritedVisibility,
                Option<&Aabb>,
                Option<&MaterialIndex>,
                Option<&SkinnedMesh>,
                Option<&MeshMorphWeights>,
            ),
            Without<NotVoxelized>,
        >,
    >,
    joints: Extract<Query<&GlobalTransform>>,
    morphs: Extract<Query<&MorphWeights>>,
    bind_poses: Extract<Res<Assets<SkinnedMeshInverseBindposes>>>,
) {
    let scene = &mut *scene;
    scene.meshes.clear();
    scene.joints.clear();
    let edited = mesh_events
        .read()
        .any(|event| matches!(event, AssetEvent::Modified { .. }));
    scene.mesh_edits += u64::from(edited);
    let Some(volume) = &active.volume else {
        return;
    };
    let neutral = volume.settings.albedo == VoxelAlbedo::Neutral;
    let version = Some((table.version, neutral));
    if scene.version != version {
        scene.version = version;
        let mut materials = table.materials().to_vec();
        if neutral {
            for material in &mut materials {
                material.albedo = VoxelMaterial::NEUTRAL.albedo;
            }
        }
        (scene.materials, scene.indices) = sorted_by_value(&materials);
    }
    for (mesh, transform, visible, aabb, index, skin, morph) in &meshes {
        let index = index.copied().unwrap_or_default().index;
        let material = scene.indices.get(index as usize).copied().unwrap_or(0);
        let transparent = scene
            .materials
            .get(material as usize)
            .is_some_and(|material| material.transparent == 1);
        if !visible.get() || transparent {
            continue;
        }
        let world_from_local = transform.affine();
        if !world_from_local.is_finite() {
            continue;
        }
        // The bounds of skinned meshes are those of their bind pose, of morphed ones of their base shape.
        let still = skin.is_none() && morph.is_none();
        let bounds = aabb.filter(|_| still).map(|aabb| {
            let m = world_from_local.matrix3;
            let half_size = m.x_axis.abs() * aabb.half_extents.x
                + m.y_axis.abs() * aabb.half_extents.y
                + m.z_axis.abs() * aabb.half_extents.z;
            (world_from_local.transform_point3a(aabb.center), half_size)
        });
        let first_joint = match skin {
            None => None,
            Some(skin) => {
                let Some(poses) = bind_poses.get(&skin.inverse_bindposes) else {
                    continue;
                };
                let first = u32::try_from(scene.joints.len()).unwrap_or(u32::MAX);
                for (&joint, pose) in skin.joints.iter().zip(poses.iter()) {
                    let world = joints
                        .get(joint)
                        .map_or(Mat4::IDENTITY, GlobalTransform::to_matrix);
                    scene.joints.push(world * *pose);
                }
                Some(first)
            }
        };
        let weights = match morph {
            None => None,
            Some(MeshMorphWeights::Value { weights }) => Some(&weights[..]),
            Some(MeshMorphWeights::Reference(entity)) => {
                morphs.get(*entity).ok().map(MorphWeights::weights)
            }
        };
        let extracted = ExtractedMesh {
            mesh: mesh.id(),
            world_from_local,
            material,
            first_joint,
            weights: weights.map(|weights| append_weights(&mut scene.joints, weights)),
            bounds,
        };
        if volume.levels.iter().any(|level| extracted.reaches(level)) {
            scene.meshes.push(extracted);
        }
    }
}

/// Appends morph weights to the matrices, 16 in each. A separate buffer would exceed the limit of eight
/// storage buffers that some adapters have.
fn append_weights(matrices: &mut Vec<Mat4>, weights: &[f32]) -> (u32, u32) {
    let first = u32::try_from(matrices.len()).unwrap_or(u32::MAX);
    let count = u32::try_from(weights.len()).unwrap_or(0);
    matrices.extend(weights.chunks(16).map(|chunk| {
        let mut all = [0.0; 16];
        for (to, from) in all.iter_mut().zip(chunk) {
            *to = if from.is_finite() { *from } else { 0.0 };
        }
        Mat4::from_cols_array(&all)
    }));
    (first, count)
}

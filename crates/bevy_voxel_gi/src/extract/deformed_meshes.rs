//! Extracts the meshes with a skin or morph targets, which may change in every frame.

use bevy::{
    mesh::{
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    render::Extract,
};

use super::{
    meshes::{ExtractedMesh, ExtractedScene, MeshParts},
    place_volume::ActiveVolume,
};
use crate::settings::NotVoxelized;

type IsDeformed = (
    Without<NotVoxelized>,
    Or<(With<SkinnedMesh>, With<MeshMorphWeights>)>,
);

/// Extracts them, once the materials are.
pub(crate) fn extract_deformed_meshes(
    mut scene: ResMut<ExtractedScene>,
    active: Extract<Res<ActiveVolume>>,
    meshes: Extract<
        Query<(MeshParts, Option<&SkinnedMesh>, Option<&MeshMorphWeights>), IsDeformed>,
    >,
    joints: Extract<Query<&GlobalTransform>>,
    morphs: Extract<Query<&MorphWeights>>,
    bind_poses: Extract<Res<Assets<SkinnedMeshInverseBindposes>>>,
) {
    let scene = &mut *scene;
    scene.deformed.clear();
    scene.joints.clear();
    if active.volume.is_none() {
        return;
    }
    for (parts, skin, morph) in &meshes {
        let Some(mesh) = scene.rigid_mesh(parts) else {
            continue;
        };
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
        let weights = weights.map(|weights| append_weights(&mut scene.joints, weights));
        scene.deformed.push(ExtractedMesh {
            first_joint,
            weights,
            // Theirs are those of the bind pose and of the base shape.
            bounds: None,
            ..mesh
        });
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

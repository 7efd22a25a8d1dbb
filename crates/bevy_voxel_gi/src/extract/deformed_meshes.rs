//! Extracts the meshes with a skin or morph targets, which may change in every frame.

use std::hash::{BuildHasher, Hasher};

use bevy::{
    camera::{primitives::Aabb, visibility::DynamicSkinnedMeshBounds},
    ecs::entity::EntityHashSet,
    math::{Affine3A, Vec3A},
    mesh::{
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    platform::hash::FixedHasher,
    prelude::*,
    render::Extract,
};

use super::{
    meshes::{ExtractedScene, MeshParts, world_bounds},
    place_volume::ActiveVolume,
};
use crate::{
    prepare::{
        asset_notes::{AssetNotes, Displacement},
        plan::hash_floats,
    },
    settings::NotVoxelized,
};

type IsDeformed = (
    Without<NotVoxelized>,
    Or<(With<SkinnedMesh>, With<MeshMorphWeights>)>,
);

/// What deforms a mesh, and what keeps its bounds.
type Deformation = (
    Option<&'static SkinnedMesh>,
    Option<&'static MeshMorphWeights>,
    Has<DynamicSkinnedMeshBounds>,
);

/// Extracts those that may reach into a level, once the materials are.
pub(crate) fn extract_deformed_meshes(
    mut scene: ResMut<ExtractedScene>,
    active: Extract<Res<ActiveVolume>>,
    meshes: Extract<Query<(Entity, MeshParts, Deformation), IsDeformed>>,
    joints: Extract<Query<&GlobalTransform>>,
    morphs: Extract<Query<&MorphWeights>>,
    bind_poses: Extract<Res<Assets<SkinnedMeshInverseBindposes>>>,
    notes: Res<AssetNotes>,
) {
    let scene = &mut *scene;
    let before = std::mem::take(&mut scene.deformed);
    scene.joints.clear();
    let Some(volume) = &active.volume else {
        return;
    };
    for (entity, parts, (skin, morph, has_dynamic_bounds)) in &meshes {
        let Some(mut mesh) = scene.rigid_mesh(&parts) else {
            continue;
        };
        let weights = match morph {
            None => None,
            Some(MeshMorphWeights::Value { weights }) => Some(&weights[..]),
            Some(MeshMorphWeights::Reference(entity)) => {
                morphs.get(*entity).ok().map(MorphWeights::weights)
            }
        };
        let shape = parts.shape().map(|shape| {
            let displacements = notes.displacements(mesh.mesh);
            let morphed = morphed(shape, weights.unwrap_or_default(), displacements);
            if has_dynamic_bounds {
                turned(shape, &morphed)
            } else {
                morphed
            }
        });
        mesh.bounds = shape.and_then(|shape| world_bounds(&shape, &mesh.world_from_local));
        let first_matrix = scene.joints.len();
        if let Some(skin) = skin {
            let Some(poses) = bind_poses.get(&skin.inverse_bindposes) else {
                continue;
            };
            for (&joint, pose) in skin.joints.iter().zip(poses.iter()) {
                let world = joints
                    .get(joint)
                    .map_or(Mat4::IDENTITY, GlobalTransform::to_matrix);
                scene.joints.push(world * *pose);
            }
            mesh.first_joint = Some(u32::try_from(first_matrix).unwrap_or(u32::MAX));
            if !has_dynamic_bounds {
                let matrices = &scene.joints[first_matrix..];
                mesh.bounds = shape.and_then(|shape| skinned_bounds(&shape, matrices));
            }
        }
        if !volume.levels.iter().any(|level| mesh.reaches(level)) {
            scene.joints.truncate(first_matrix);
            continue;
        }
        mesh.weights =
            morph.map(|_| append_weights(&mut scene.joints, weights.unwrap_or_default()));
        let mut pose = FixedHasher.build_hasher();
        for matrix in &scene.joints[first_matrix..] {
            hash_floats(&mut pose, &matrix.to_cols_array());
        }
        mesh.pose = pose.finish();
        scene.deformed.push(entity);
        scene.meshes.set(entity, Some(mesh));
    }
    if before != scene.deformed {
        let now: EntityHashSet = scene.deformed.iter().copied().collect();
        for entity in before.into_iter().filter(|entity| !now.contains(entity)) {
            let mesh = scene.meshes.get(entity);
            // It may be rigid by now.
            if mesh.is_some_and(|mesh| mesh.is_deformed()) {
                scene.meshes.set(entity, None);
            }
        }
    }
}

/// How far a morph target is assumed to displace vertices at most, as a multiple of the size of the base shape, until
/// its displacements are known.
const MORPH_REACH: f32 = 2.0;

/// The bounds of a shape with its morph targets, in its own space.
fn morphed(shape: &Aabb, weights: &[f32], displacements: Option<&[Displacement]>) -> Aabb {
    let (mut least, mut greatest) = (shape.min(), shape.max());
    for (target, weight) in weights.iter().enumerate() {
        let weight = finite(*weight);
        let [a, b] = match displacements {
            Some(all) => all.get(target).map_or([Vec3A::ZERO; 2], |displacement| {
                [displacement.least, displacement.greatest].map(|d| weight * Vec3A::from(d))
            }),
            None => [-1.0, 1.0].map(|side| side * weight * MORPH_REACH * shape.half_extents),
        };
        least += a.min(b);
        greatest += a.max(b);
    }
    Aabb::from_min_max(least.into(), greatest.into())
}

/// The bounds of a shape where joints turn by what it is morphed.
fn turned(shape: &Aabb, morphed: &Aabb) -> Aabb {
    let reach = (morphed.min() - shape.min())
        .abs()
        .max((morphed.max() - shape.max()).abs());
    Aabb {
        half_extents: shape.half_extents + reach.length(),
        ..*shape
    }
}

fn finite(weight: f32) -> f32 {
    if weight.is_finite() { weight } else { 0.0 }
}

/// Centre and half extents of a skin whose bounds in bind pose are known: each vertex is a mean of where single joints
/// move it. `None` if it has no joints, or one that is not finite.
fn skinned_bounds(bind_pose: &Aabb, joints: &[Mat4]) -> Option<(Vec3A, Vec3A)> {
    let of_joint = |joint: &Mat4| {
        let (center, half_size) = world_bounds(bind_pose, &Affine3A::from_mat4(*joint))?;
        Some((center - half_size, center + half_size))
    };
    let all = joints.iter().map(of_joint);
    let (low, high) = all.reduce(|a, b| Some((a?.0.min(b?.0), a?.1.max(b?.1))))??;
    Some((0.5 * (low + high), 0.5 * (high - low)))
}

/// Appends morph weights to the matrices, 16 in each. A separate buffer would exceed the limit of eight
/// storage buffers that some adapters have.
fn append_weights(matrices: &mut Vec<Mat4>, weights: &[f32]) -> (u32, u32) {
    let first = u32::try_from(matrices.len()).unwrap_or(u32::MAX);
    let count = u32::try_from(weights.len()).unwrap_or(0);
    matrices.extend(weights.chunks(16).map(|chunk| {
        let mut all = [0.0; 16];
        for (to, from) in all.iter_mut().zip(chunk) {
            *to = finite(*from);
        }
        Mat4::from_cols_array(&all)
    }));
    (first, count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_a_morphed_shape_contain_it_and_no_more() {
        let shape = Aabb::from_min_max(Vec3::ZERO, Vec3::ONE);
        let displacements = [
            Displacement {
                least: Vec3::new(-1.0, 0.0, 0.0),
                greatest: Vec3::new(3.0, 0.0, 0.5),
            },
            Displacement {
                least: Vec3::ZERO,
                greatest: Vec3::Y,
            },
        ];
        let found = morphed(&shape, &[2.0, -0.5, f32::NAN], Some(&displacements));
        let expected = Aabb::from_min_max(Vec3::new(-2.0, -0.5, 0.0), Vec3::new(7.0, 1.0, 2.0));
        assert_eq!(found, expected);
        let unknown = morphed(&shape, &[-0.5], None);
        assert_eq!(
            unknown,
            Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(1.5))
        );
    }

    #[test]
    fn bounds_of_a_skin_contain_what_its_joints_move() {
        let bind_pose = Aabb {
            center: Vec3A::new(0.0, 1.0, 0.0),
            half_extents: Vec3A::new(0.5, 1.0, 0.25),
        };
        assert_eq!(skinned_bounds(&bind_pose, &[]), None);
        let joints = [
            Mat4::from_translation(Vec3::X * 10.0),
            Mat4::from_rotation_z(1.0) * Mat4::from_translation(Vec3::Y),
        ];
        let (center, half_size) = skinned_bounds(&bind_pose, &joints).expect("joints");
        for corner in 0..8 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let vertex =
                bind_pose.center + bind_pose.half_extents * Vec3A::new(sign(0), sign(1), sign(2));
            for weight in [0.0, 0.3, 1.0] {
                let skinned = joints[0] * weight + joints[1] * (1.0 - weight);
                let outside = (skinned.transform_point3a(vertex) - center).abs() - half_size;
                assert!(outside.max_element() < 1e-5, "{outside}");
            }
        }
        assert!(half_size.x < 8.0, "{half_size}");
    }
}

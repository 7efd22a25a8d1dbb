//! A ray through the voxels: from voxel to voxel, and through the sub-voxels of those with any.
//!
//! It visits every sub-voxel it passes (J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm for
//! Ray Tracing*, 1987), so that nothing is missed, unlike by the thesis's steps of equal length (6.6.1).

use super::voxels::{SUB_VOXELS, Voxels, sub_voxel_bit};
use glam::{IVec3, Vec3};

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the voxel.
    pub voxel: usize,
    /// The sub-voxel, counted from the volume's lowest corner.
    pub sub_voxel: IVec3,
    /// Distance along the ray, in voxels.
    pub distance: f32,
}

fn smallest(v: Vec3) -> usize {
    if v.x < v.y {
        if v.x < v.z { 0 } else { 2 }
    } else if v.y < v.z {
        1
    } else {
        2
    }
}

/// The first touched sub-voxel on the way of a ray, None if there is none before `reach` or the
/// volume's end.
///
/// `origin` is in grid coordinates, `direction` a unit vector, `reach` in voxels.
pub fn trace(voxels: &Voxels, origin: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
    // A component of 0 never reaches a border; a tiny one does so out of sight, and is finite.
    let direction = Vec3::select(
        direction.abs().cmplt(Vec3::splat(1e-12)),
        Vec3::splat(1e-12),
        direction,
    );
    let inverse = direction.recip();
    let ahead = Vec3::select(direction.cmpgt(Vec3::ZERO), Vec3::ONE, Vec3::ZERO);
    let step = IVec3::select(direction.cmpgt(Vec3::ZERO), IVec3::ONE, IVec3::NEG_ONE);
    let mut voxel = origin.floor().as_ivec3();
    let mut distance = 0.0;
    loop {
        let index = voxels.grid.index(voxel)?;
        let mask = voxels.masks[index];
        if mask != 0 {
            let mut at = distance;
            let scale = SUB_VOXELS as f32;
            let entry = (origin + direction * at - voxel.as_vec3()) * scale;
            let last = IVec3::splat(SUB_VOXELS - 1);
            let mut sub = entry.floor().as_ivec3().clamp(IVec3::ZERO, last);
            loop {
                if at >= reach {
                    return None;
                }
                if mask & sub_voxel_bit(sub) != 0 {
                    return Some(Hit {
                        voxel: index,
                        sub_voxel: voxel * SUB_VOXELS + sub,
                        distance: at,
                    });
                }
                let border = voxel.as_vec3() + (sub.as_vec3() + ahead) / scale;
                let next = (border - origin) * inverse;
                let axis = smallest(next);
                at = next[axis];
                sub[axis] += step[axis];
                if !(0..SUB_VOXELS).contains(&sub[axis]) {
                    break;
                }
            }
        }
        let next = (voxel.as_vec3() + ahead - origin) * inverse;
        let axis = smallest(next);
        distance = next[axis];
        if distance >= reach {
            return None;
        }
        voxel[axis] += step[axis];
    }
}

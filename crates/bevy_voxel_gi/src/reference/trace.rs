//! A ray through the voxels: from voxel to voxel, and through the sub-voxels of those with any.
//!
//! It visits every sub-voxel it passes (J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm for
//! Ray Tracing*, 1987), so that nothing is missed, unlike by the thesis's steps of equal length (6.6.1).
//! In a touched one it ends if it comes behind the middle.

use super::{
    grid::FACE_STEPS,
    key::key_normal,
    seen::{is_away, is_turned},
    voxels::{SUB_VOXELS, Voxels, sub_voxel_bit},
};
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
    /// What the ray grazed in the sub-voxel just before.
    pub grazed: Option<Grazed>,
}

/// A surface that a ray passes in a sub-voxel which it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grazed {
    /// The ray stays in front of it: index of the voxel, and face.
    Front(usize, usize),
    /// It stays behind.
    Back,
    /// It was in front of it before, and goes away.
    Left,
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

/// The sub-voxel in which a ray meets a surface, None if there is none before `reach` or the volume's
/// end.
///
/// `origin` is in grid coordinates, `direction` a unit vector, `reach` in voxels.
pub fn trace(voxels: &Voxels, origin: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
    walk(voxels, origin, direction, reach, true)
}

/// The same for the first touched sub-voxel, wherever its surface is.
pub fn trace_touched(voxels: &Voxels, origin: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
    walk(voxels, origin, direction, reach, false)
}

fn walk(voxels: &Voxels, origin: Vec3, direction: Vec3, reach: f32, grazes: bool) -> Option<Hit> {
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
    let mut grazed = None;
    loop {
        let index = voxels.grid.index(voxel)?;
        let mask = voxels.masks[index];
        if mask == 0 {
            grazed = None;
        } else {
            let mut at = distance;
            let scale = SUB_VOXELS as f32;
            let entry = (origin + direction * at - voxel.as_vec3()) * scale;
            let last = IVec3::splat(SUB_VOXELS - 1);
            let mut sub = entry.floor().as_ivec3().clamp(IVec3::ZERO, last);
            loop {
                if at >= reach {
                    return None;
                }
                let border = voxel.as_vec3() + (sub.as_vec3() + ahead) / scale;
                let next = (border - origin) * inverse;
                let axis = smallest(next);
                if mask & sub_voxel_bit(sub) != 0 {
                    let hit = Hit {
                        voxel: index,
                        sub_voxel: voxel * SUB_VOXELS + sub,
                        distance: at,
                        grazed,
                    };
                    let exit = origin + direction * next[axis];
                    let passed = grazes
                        .then(|| passed(voxels, &hit, direction, origin + direction * at, exit))
                        .flatten();
                    if passed.is_none() {
                        return Some(hit);
                    }
                    grazed = passed;
                } else {
                    grazed = None;
                }
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

/// What a ray only grazes in a touched sub-voxel, which it leaves by `exit`; None if it meets that.
///
/// The surface is taken to go through the middle: where in the sub-voxel it really is nobody knows, but
/// so it is at the right place in the mean, while all of the sub-voxel would be too near, and windows too
/// narrow.
fn passed(voxels: &Voxels, hit: &Hit, direction: Vec3, entry: Vec3, exit: Vec3) -> Option<Grazed> {
    let middle = (hit.sub_voxel.as_vec3() + 0.5) / SUB_VOXELS as f32;
    let height = |face: usize, at: Vec3| key_normal(voxels.keys[hit.voxel][face]).dot(at - middle);
    let is_own = |face: usize| voxels.is_outermost(hit.sub_voxel, FACE_STEPS[face]);
    let mut turned = (0..6)
        .filter(|&face| is_turned(voxels, hit, direction, face))
        .peekable();
    if turned.peek().is_some() {
        return turned
            .find(|&face| height(face, exit) >= 0.0 && is_own(face))
            .map(|face| Grazed::Front(hit.voxel, face));
    }
    // Behind one of two that make an edge a ray may be in front of the other.
    let away = |is_clear: &dyn Fn(usize) -> bool| {
        let mut faces = (0..6)
            .filter(|&face| is_away(voxels, hit, direction, face))
            .peekable();
        faces.peek().is_some() && faces.all(|face| is_own(face) && is_clear(face))
    };
    if away(&|face| height(face, exit) <= 0.0) {
        Some(Grazed::Back)
    } else if hit.grazed != Some(Grazed::Back) && away(&|face| height(face, entry) >= 0.0) {
        Some(Grazed::Left)
    } else {
        None
    }
}

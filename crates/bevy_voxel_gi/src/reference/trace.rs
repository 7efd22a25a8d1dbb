//! Ray tracing: steps a ray through the voxels, and through the sub-voxels of occupied ones.
//!
//! The ray visits every sub-voxel along it (J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm
//! for Ray Tracing*, 1987), so nothing is missed, unlike with the thesis's steps of equal length (6.6.1).
//! In an occupied one it hits if it crosses the surface's plane through the sub-voxel's centre.

use super::{
    grid::FACE_STEPS,
    hit::{Hit, PassedSurface},
    packed_surface::packed_normal,
    voxels::{SUB_VOXELS, Voxels, sub_voxel_bit},
};
use glam::{IVec3, Vec3};

fn smallest_axis(v: Vec3) -> usize {
    if v.x < v.y {
        if v.x < v.z { 0 } else { 2 }
    } else if v.y < v.z {
        1
    } else {
        2
    }
}

/// Returns the sub-voxel in which a ray hits a surface, `None` if there is none before `reach` or before
/// the ray leaves the volume.
///
/// `origin` is in grid coordinates, `direction` is a unit vector, `reach` is in voxels.
pub fn trace(voxels: &Voxels, origin: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
    traverse(voxels, origin, direction, reach, true)
}

/// Returns the first occupied sub-voxel along a ray, wherever its surface is; see [`trace`].
pub fn first_occupied(voxels: &Voxels, origin: Vec3, direction: Vec3, reach: f32) -> Option<Hit> {
    traverse(voxels, origin, direction, reach, false)
}

/// The first hit, or, without `may_pass`, the first occupied sub-voxel.
fn traverse(
    voxels: &Voxels,
    origin: Vec3,
    direction: Vec3,
    reach: f32,
    may_pass: bool,
) -> Option<Hit> {
    // A component of 0 would give infinities; a tiny one reaches the border far outside, and is finite.
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
    let mut passed = None;
    loop {
        let index = voxels.grid.index(voxel)?;
        let mask = voxels.masks[index];
        if mask == 0 {
            passed = None;
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
                let axis = smallest_axis(next);
                if mask & sub_voxel_bit(sub) != 0 {
                    let hit = Hit {
                        voxel: index,
                        sub_voxel: voxel * SUB_VOXELS + sub,
                        distance: at,
                        passed,
                    };
                    let exit = origin + direction * next[axis];
                    let passes = may_pass
                        .then(|| {
                            passed_surface(voxels, &hit, direction, origin + direction * at, exit)
                        })
                        .flatten();
                    if passes.is_none() {
                        return Some(hit);
                    }
                    passed = passes;
                } else {
                    passed = None;
                }
                at = next[axis];
                sub[axis] += step[axis];
                if !(0..SUB_VOXELS).contains(&sub[axis]) {
                    break;
                }
            }
        }
        let next = (voxel.as_vec3() + ahead - origin) * inverse;
        let axis = smallest_axis(next);
        distance = next[axis];
        if distance >= reach {
            return None;
        }
        voxel[axis] += step[axis];
    }
}

/// The surface that a ray passes in an occupied sub-voxel, which it leaves at `exit`; `None` for a hit.
///
/// The surface is assumed to go through the sub-voxel's centre. Its position within the sub-voxel is
/// unknown, but this is right on average, while taking the whole sub-voxel as solid would put surfaces
/// too near and make windows too narrow.
fn passed_surface(
    voxels: &Voxels,
    hit: &Hit,
    direction: Vec3,
    entry: Vec3,
    exit: Vec3,
) -> Option<PassedSurface> {
    let center = (hit.sub_voxel.as_vec3() + 0.5) / SUB_VOXELS as f32;
    let height = |face: usize, at: Vec3| {
        packed_normal(voxels.packed_surfaces[hit.voxel][face]).dot(at - center)
    };
    let is_own = |face: usize| voxels.is_outermost(hit.sub_voxel, FACE_STEPS[face]);
    let mut front = (0..6)
        .filter(|&face| hit.is_front_facing(voxels, direction, face))
        .peekable();
    if front.peek().is_some() {
        return front
            .find(|&face| height(face, exit) >= 0.0 && is_own(face))
            .map(|face| PassedSurface::Front(hit.voxel, face));
    }
    // Behind one of two surfaces that form an edge, a ray may be in front of the other.
    let passes_back = |is_clear: &dyn Fn(usize) -> bool| {
        let mut faces = (0..6)
            .filter(|&face| hit.is_back_facing(voxels, direction, face))
            .peekable();
        faces.peek().is_some() && faces.all(|face| is_own(face) && is_clear(face))
    };
    if passes_back(&|face| height(face, exit) <= 0.0) {
        Some(PassedSurface::Back)
    } else if hit.passed != Some(PassedSurface::Back)
        && passes_back(&|face| height(face, entry) >= 0.0)
    {
        Some(PassedSurface::Left)
    } else {
        None
    }
}

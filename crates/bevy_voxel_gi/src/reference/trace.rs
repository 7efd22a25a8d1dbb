//! Ray tracing and the light that a ray receives from its hit. It steps a ray through the voxels, and through the sub-voxels of occupied ones.
//!
//! The ray visits every sub-voxel along it (J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm
//! for Ray Tracing*, 1987), so nothing is missed, unlike with the thesis's steps of equal length (6.6.1).
//! In an occupied one it hits if it crosses the surface's plane.

use super::{
    grid::{FACE_STEPS, FACES},
    overlap::SINK,
    packed_surface::{HEIGHT_ERROR, Plane, packed_normal},
    voxels::{SUB_VOXELS, Voxels, sub_voxel_bit},
};
use glam::{IVec3, Vec3};

/// The hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the voxel.
    pub voxel: usize,
    /// The sub-voxel, counted from the volume's lowest corner.
    pub sub_voxel: IVec3,
    /// Distance along the ray, in voxels.
    pub distance: f32,
    /// The surface that the ray passed in the sub-voxel just before.
    pub passed: Option<PassedSurface>,
}

/// A surface that a ray passes without a hit in one of its sub-voxels: a near miss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassedSurface {
    /// The ray stays in front of the surface: index of the voxel, and face.
    Front(usize, usize),
    /// The ray stays behind the surface.
    Back,
    /// The ray was in front of the back-facing surface when it entered the sub-voxel, and leaves it.
    Left,
}

impl Hit {
    /// Returns whether a face of the hit voxel has a front-facing surface.
    pub fn is_front_facing(&self, voxels: &Voxels, direction: Vec3, face: usize) -> bool {
        let packed = voxels.packed_surfaces[self.voxel][face];
        packed != 0
            && direction.dot(FACES[face]) < 0.0
            && direction.dot(packed_normal(packed)) < 0.0
    }

    /// Returns whether a face of the hit voxel has a back-facing surface, which the ray reaches from
    /// behind.
    pub fn is_back_facing(&self, voxels: &Voxels, direction: Vec3, face: usize) -> bool {
        let packed = voxels.packed_surfaces[self.voxel][face];
        packed != 0
            && direction.dot(FACES[face]) > 0.0
            && direction.dot(packed_normal(packed)) > 0.0
    }
}

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

/// A surface at a sub-voxel.
struct PlaneAt {
    /// Whether nothing of the surface's voxel, and nothing in the next one, is in front of the sub-voxel.
    is_own: bool,
    is_exact: bool,
    /// Whether the plane is exact and crosses the sub-voxel.
    is_here: bool,
    /// Heights above it at which a ray enters the sub-voxel and leaves it. If the plane is not exact, or does not cross the
    /// sub-voxel, it is taken to go through its centre, which is right on average.
    entry: f32,
    exit: f32,
    /// What is that far behind the plane is so in spite of the error of its height.
    margin: f32,
}

impl PlaneAt {
    /// Where along its way through the sub-voxel, from 0 to 1, or before or after it, a ray crosses the plane.
    fn crossing(&self) -> Option<f32> {
        let fall = self.entry - self.exit;
        (fall.abs() > 1e-6).then(|| self.entry / fall)
    }
}

/// Whether the surfaces of a face and of that behind it are the two sides of a wall without thickness.
fn is_card(voxels: &Voxels, hit: &Hit, face: usize) -> bool {
    let behind = voxels.packed_surfaces[hit.voxel][face ^ 1];
    let [front, back] = [voxels.packed_surfaces[hit.voxel][face], behind].map(Plane::new);
    behind != 0
        && front.normal.dot(back.normal) <= -0.5
        && front.height + back.height + 2.0 * SINK < HEIGHT_ERROR
}

/// The surface that a ray passes in an occupied sub-voxel, which it leaves at `exit`; `None` for a hit.
///
/// A ray passes where it does not cross the planes of the surfaces: to take the whole sub-voxel as solid would put
/// surfaces too near and make windows too narrow.
fn passed_surface(
    voxels: &Voxels,
    hit: &Hit,
    direction: Vec3,
    entry: Vec3,
    exit: Vec3,
) -> Option<PassedSurface> {
    let middle = voxels.grid.voxel(hit.voxel).as_vec3() + 0.5;
    let center = (hit.sub_voxel.as_vec3() + 0.5) / SUB_VOXELS as f32 - middle;
    let at = |face: usize| {
        let plane = Plane::new(voxels.packed_surfaces[hit.voxel][face]);
        let is_here = plane.crosses(center, 0.0);
        let shift = if is_here {
            SINK
        } else {
            plane.height_of(center)
        };
        PlaneAt {
            is_own: voxels.is_outermost(hit.sub_voxel, FACE_STEPS[face]),
            is_exact: plane.is_exact(),
            is_here,
            entry: plane.height_of(entry - middle) - shift,
            exit: plane.height_of(exit - middle) - shift,
            margin: if is_here { HEIGHT_ERROR } else { 0.0 },
        }
    };
    let faces = (0..6).filter(|&face| hit.is_front_facing(voxels, direction, face));
    let front: Vec<(usize, PlaneAt)> = faces.map(|face| (face, at(face))).collect();
    if !front.is_empty() {
        let stays_in_front = |plane: &PlaneAt| plane.is_own && plane.exit >= 0.0;
        if let Some((face, _)) = front.iter().find(|(_, plane)| stays_in_front(plane)) {
            return Some(PassedSurface::Front(hit.voxel, *face));
        }
        let planes = || front.iter().map(|(_, plane)| plane);
        // Beside an edge, a ray leaves a solid at one plane before it enters it at another, or has left it before it comes
        // where nothing of that other plane is, as above a window's sill. The back of a wall without thickness is no edge.
        let one_is_absent =
            !planes().any(|p| p.is_own) || planes().any(|p| p.is_exact && !p.is_own);
        let enters = planes()
            .filter(|p| p.is_own && p.is_exact)
            .filter_map(PlaneAt::crossing)
            .fold(
                if one_is_absent {
                    0.0
                } else {
                    f32::NEG_INFINITY
                },
                f32::max,
            );
        let leaves = (0..6)
            .filter(|&face| hit.is_back_facing(voxels, direction, face))
            .filter(|&face| !is_card(voxels, hit, face))
            .map(at)
            .filter(|p| p.is_own && p.is_here)
            .filter_map(|p| p.crossing())
            .fold(f32::INFINITY, f32::min);
        if leaves <= enters {
            return Some(PassedSurface::Left);
        }
        // From the side, behind a surface that ends here.
        let was_free = matches!(hit.passed, None | Some(PassedSurface::Left));
        let is_beside = planes().all(|p| p.is_own && p.is_here && p.entry < -p.margin);
        return (was_free && is_beside).then_some(PassedSurface::Left);
    }
    // Behind one of two surfaces that form an edge, a ray may be in front of the other.
    let passes_back = |is_clear: &dyn Fn(PlaneAt) -> bool| {
        let mut planes = (0..6)
            .filter(|&face| hit.is_back_facing(voxels, direction, face))
            .map(at)
            .peekable();
        planes.peek().is_some() && planes.all(|plane| plane.is_own && is_clear(plane))
    };
    if passes_back(&|plane| plane.exit <= -plane.margin) {
        Some(PassedSurface::Back)
    } else if hit.passed != Some(PassedSurface::Back) && passes_back(&|plane| plane.entry >= 0.0) {
        Some(PassedSurface::Left)
    } else {
        None
    }
}

/// The result of tracing a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RaySample<T> {
    /// The ray hit the front of a surface, or nothing: the light from there.
    Light(T),
    /// The ray hit the back of a single-sided surface, which is black, at a distance in voxels.
    BackFace(f32),
    /// The ray hit a sub-voxel without a front-facing surface, though its voxel has one, as inside a thin
    /// wall: the sample is invalid.
    Invalid,
}

impl<T> RaySample<T> {
    /// Converts the light.
    pub fn map<U>(self, change: impl FnOnce(T) -> U) -> RaySample<U> {
        match self {
            Self::Light(light) => RaySample::Light(change(light)),
            Self::BackFace(distance) => RaySample::BackFace(distance),
            Self::Invalid => RaySample::Invalid,
        }
    }

    /// Returns whether the ray ends at a back or in a wall, as all rays in a solid do.
    pub fn is_enclosed(&self) -> bool {
        !matches!(self, Self::Light(_))
    }

    /// Returns whether the ray may start in a solid, close to its surface.
    ///
    /// Only the region near the surface of a large solid matters: receivers outside interpolate with it.
    pub fn is_inside_geometry(&self) -> bool {
        match self {
            Self::Light(_) => false,
            Self::BackFace(distance) => *distance < NEAR,
            Self::Invalid => true,
        }
    }
}

/// A back face that is hit nearer than this, in voxels, may belong to the solid in which the ray starts.
pub const NEAR: f32 = 1.5;

/// Returns the weight of each face of a hit voxel, 1 in total.
///
/// The weight is the squared cosine if the face's surface is front-facing and the hit sub-voxel is one of
/// that surface's own: otherwise the outside of a thin wall would be visible from inside.
pub fn face_weights(voxels: &Voxels, hit: &Hit, direction: Vec3) -> RaySample<[f32; 6]> {
    let mut is_back_face = true;
    let weights = [0, 1, 2, 3, 4, 5].map(|face| {
        if !hit.is_front_facing(voxels, direction, face) {
            return 0.0;
        }
        is_back_face = false;
        let is_own = voxels.is_outermost(hit.sub_voxel, FACE_STEPS[face]);
        let cosine = direction.dot(FACES[face]);
        if is_own { cosine * cosine } else { 0.0 }
    });
    let sum: f32 = weights.iter().sum();
    if sum > 0.0 {
        RaySample::Light(weights.map(|w| w / sum))
    } else if is_back_face {
        RaySample::BackFace(hit.distance)
    } else {
        RaySample::Invalid
    }
}

/// Returns the radiance of a hit, where `radiance` is per voxel and face. In the edge between two
/// surfaces it is that of the surface that the ray passed.
pub fn hit_radiance(
    voxels: &Voxels,
    hit: &Hit,
    direction: Vec3,
    radiance: impl Fn(usize, usize) -> Vec3,
) -> RaySample<Vec3> {
    let sample = face_weights(voxels, hit, direction).map(|weights| {
        (0..6)
            .map(|face| radiance(hit.voxel, face) * weights[face])
            .sum()
    });
    match (sample, hit.passed) {
        (RaySample::Invalid, Some(PassedSurface::Front(voxel, face))) => {
            RaySample::Light(radiance(voxel, face))
        }
        (RaySample::Invalid, Some(PassedSurface::Back)) => RaySample::BackFace(hit.distance),
        _ => sample,
    }
}

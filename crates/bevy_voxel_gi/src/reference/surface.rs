//! The surfaces in a voxel, each with the points at which rays start.

use super::{
    dividers::is_beyond_divider,
    each,
    grid::FACE_STEPS,
    packed_surface::{Plane, packed_normal_bits},
    trace::first_occupied,
    voxels::{SUB_VOXELS, Voxels, sub_voxels},
};
use glam::Vec3;

/// Distance between the sub-voxels that a surface fills and the origins of its rays, in voxels.
pub const CLEARANCE: f32 = 1.0 / 256.0;

/// Rays to lights at a smaller cosine to the normal start less far above the surface, so that they start within a voxel.
const MIN_START_COSINE: f32 = 0.25;

/// A surface that represents one or several faces of a voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Index of the voxel.
    pub voxel: usize,
    /// Bit `f` is set if the surface represents face `f`.
    pub faces: u8,
    /// Unit normal.
    pub normal: Vec3,
    /// Distance of its plane from the voxel's centre along the normal, in voxels.
    pub height: f32,
    /// Points on it, one per sub-voxel that is exposed in front, in grid coordinates.
    pub points: Vec<Vec3>,
    /// Indices of the points from which light is gathered: one side, if a wall divides the surface.
    pub one_side: Vec<usize>,
    /// Ray offset along the normal (thesis: guard distance), in voxels: rays start outside of the
    /// sub-voxels that the surface itself fills.
    pub ray_offset: f32,
}

impl Surface {
    /// Returns the faces that it represents.
    pub fn faces(&self) -> impl Iterator<Item = usize> {
        let faces = self.faces;
        (0..6).filter(move |face| faces >> face & 1 != 0)
    }

    /// Returns the origin of rays from a point.
    pub fn origin(&self, point: usize) -> Vec3 {
        self.points[point] + self.normal * self.ray_offset
    }

    /// Returns the origin of a ray from a point to a light, and its distance from the point in voxels.
    ///
    /// It is on the line from the point to the light, as an origin above the point would displace shadows and patches of
    /// sunlight; above the point, where an occluder is between the two origins.
    pub fn start_towards(&self, voxels: &Voxels, point: usize, direction: Vec3) -> (Vec3, f32) {
        let above = self.origin(point);
        let along = self.ray_offset / self.normal.dot(direction).max(MIN_START_COSINE);
        let beside = self.points[point] + direction * along;
        if is_clear(voxels, above, beside) {
            (beside, along)
        } else {
            (above, self.ray_offset)
        }
    }
}

/// Returns the face whose normal is closest to a direction.
pub fn main_face(direction: Vec3) -> usize {
    let axis = direction.abs().max_position();
    2 * axis + usize::from(direction[axis] < 0.0)
}

/// Returns the surfaces of all voxels, in the order of voxels and faces. A surface none of whose
/// sub-voxels is exposed is left out. Whether receivers test visibility decides from which points light is gathered.
pub fn surfaces(voxels: &Voxels, tests_visibility: bool) -> Vec<Surface> {
    each(voxels.grid.len(), |index| {
        surfaces_of(voxels, index, tests_visibility)
    })
    .into_iter()
    .flatten()
    .collect()
}

fn surfaces_of(voxels: &Voxels, index: usize, tests_visibility: bool) -> Vec<Surface> {
    let packed_surfaces = voxels.packed_surfaces[index];
    let mut found = Vec::new();
    for face in 0..6 {
        let own = packed_normal_bits(packed_surfaces[face]);
        let is_own = |packed: u32| packed != 0 && packed_normal_bits(packed) == own;
        if !is_own(packed_surfaces[face]) || packed_surfaces[..face].iter().any(|p| is_own(*p)) {
            continue;
        }
        let faces = (0..6).fold(0, |all, f| all | u8::from(is_own(packed_surfaces[f])) << f);
        let mut plane = Plane::new(packed_surfaces[face]);
        let (points, ray_offset) = points_of(voxels, index, &mut plane);
        if !points.is_empty() {
            let one_side = if tests_visibility {
                visible_points(voxels, index, &points, plane.normal * ray_offset)
            } else {
                near_points(voxels, index, &points, plane)
            };
            found.push(Surface {
                voxel: index,
                faces,
                normal: plane.normal,
                height: plane.height,
                points,
                one_side,
                ray_offset,
            });
        }
    }
    found
}

/// Centres of the outermost sub-voxels that are exposed in front, projected along the normal onto the plane; and the ray
/// offset.
///
/// Sub-voxels that an exact plane does not touch belong to something else in the voxel: rays from a point of the plane
/// there would start inside of what stands on it. They do not count unless there are no others or the plane is not exact;
/// then the plane goes through their mean.
fn points_of(voxels: &Voxels, index: usize, plane: &mut Plane) -> (Vec<Vec3>, f32) {
    let voxel = voxels.grid.voxel(index);
    let base = voxel * SUB_VOXELS;
    let middle = voxel.as_vec3() + 0.5;
    let ahead = FACE_STEPS[main_face(plane.normal)];
    let exposed: Vec<Vec3> = sub_voxels()
        .map(|sub| base + sub)
        .filter(|sub| voxels.is_occupied(*sub) && voxels.is_outermost(*sub, ahead))
        .map(|sub| (sub.as_vec3() + 0.5) / SUB_VOXELS as f32)
        .collect();
    let is_own = |center: &Vec3| plane.crosses(*center - middle, CLEARANCE);
    let mut points: Vec<Vec3> = exposed.iter().copied().filter(is_own).collect();
    if points.is_empty() {
        points = exposed;
        let centroid = points.iter().sum::<Vec3>() / points.len().max(1) as f32;
        plane.height = plane.normal.dot(centroid - middle);
    }
    let heights = points.iter().map(|p| plane.height_of(*p - middle));
    let foremost = heights.fold(f32::NEG_INFINITY, f32::max);
    for point in &mut points {
        *point -= plane.normal * plane.height_of(*point - middle);
    }
    (
        points,
        foremost.min(plane.reach()) + plane.reach() + CLEARANCE,
    )
}

/// A point is nearer than another only if it is so by more than this, in voxels squared, which makes the
/// choice independent of rounding.
const NEARER: f32 = 1e-4;

/// Added for a point from which rays start in an occupied sub-voxel: more than any point's distance.
const BURIED: f32 = 4.0;

/// Indices of the points on the side of the voxel's centre, if something divides it: receivers beyond do not read it. All
/// if there are none.
fn near_points(voxels: &Voxels, index: usize, points: &[Vec3], plane: Plane) -> Vec<usize> {
    let center = voxels.grid.voxel(index).as_vec3() + 0.5;
    let is_near = |&i: &usize| !is_beyond_divider(voxels, index, points[i] - center, plane);
    let near: Vec<_> = (0..points.len()).filter(is_near).collect();
    if near.is_empty() {
        (0..points.len()).collect()
    } else {
        near
    }
}

/// Indices of the points that are visible from the one nearest to the voxel's centre, with all points
/// moved by `lift`. That one is chosen from those that are then in an empty sub-voxel, if there are any.
fn visible_points(voxels: &Voxels, index: usize, points: &[Vec3], lift: Vec3) -> Vec<usize> {
    let center = voxels.grid.voxel(index).as_vec3() + 0.5;
    let normal = lift.normalize_or_zero();
    let distance = |point: Vec3| {
        let offset = point - center;
        let flat = (offset - normal * normal.dot(offset)).length_squared();
        let start = point + lift;
        let is_free = is_clear(voxels, start, start + normal * CLEARANCE);
        flat + if is_free { 0.0 } else { BURIED }
    };
    let (mut middle, mut least) = (center, f32::INFINITY);
    for point in points {
        if distance(*point) < least - NEARER {
            (middle, least) = (*point, distance(*point));
        }
    }
    (0..points.len())
        .filter(|&i| is_clear(voxels, middle + lift, points[i] + lift))
        .collect()
}

/// Returns whether no occupied sub-voxel lies between two positions, in grid coordinates.
pub fn is_clear(voxels: &Voxels, from: Vec3, to: Vec3) -> bool {
    let path = to - from;
    let distance = path.length();
    distance < 1e-4 || first_occupied(voxels, from, path / distance, distance).is_none()
}

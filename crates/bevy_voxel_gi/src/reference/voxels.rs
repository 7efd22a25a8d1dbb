//! Voxelisation of triangles (thesis 6.4 and 6.5).
//!
//! A voxel stores which of its 4 x 4 x 4 sub-voxels triangles overlap, and for each of its six faces the
//! plane of the largest surface that faces that side, and the areas of all materials there (6.5.2, 6.5.3: a single
//! average would mix the two sides of a wall).
//!
//! Stochastic voxelisation is by random points on triangles (thesis 6.4.3; G. Turk, *Generating Random Points in
//! Triangles*, 1990). A voxel with a point has those sub-voxels that the triangle's plane crosses within its bounds. Whole
//! voxels, as in the thesis, would bring surfaces forward by half a voxel on average; the sub-voxels with a point alone
//! would let light through. What a camera sees can be added, pixel by pixel.

use super::{
    grid::{FACE_STEPS, FACES, VolumeGrid},
    overlap::{Part, SINK, TriangleOverlap, part_in_voxel},
    packed_surface::{MIN_FACE_COSINE, Plane, pack_surface},
};
use glam::{IVec3, UVec3, Vec2, Vec3};

/// Number of sub-voxels along an edge of a voxel.
pub const SUB_VOXELS: i32 = 4;

/// Least area of a triangle in a voxel that it overlaps, in units of a voxel's face: it may only touch it.
pub const MIN_AREA: f32 = 1.0 / 65_536.0;

/// Least share of what others in its voxel hide: it counts where there is nothing else.
const LEAST_SHARE: f32 = 1.0 / 64.0;

/// Bounds that end at the border of a column do not reach into the next one, whatever the rounding.
const INWARDS: f32 = 0.0625;

/// Number of voxels in front of a face and behind in which a tilted surface is taken to go on.
const CONTINUATION: i32 = 2;

/// The sub-voxels that a pixel marks are at most this many away from its own along each axis: farther ones would
/// thicken edges, and without them surfaces under grazing angles would have holes.
const REACH: i32 = 1;

/// The area of what a pixel marks, in units of a voxel's face: it decides where there is no triangle only.
const VISIBLE_AREA: f32 = 1e-12;

/// Two random numbers from 0 to below 1 (M. Jarzynski and M. Olano, *Hash Functions for GPU Rendering*, 2020: pcg3d).
fn random(key: UVec3) -> Vec2 {
    let step = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [mut x, mut y, mut z] = key.to_array().map(step);
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    [x, y, z] = [x, y, z].map(|v| v ^ (v >> 16));
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    Vec2::new((x >> 8) as f32, (y >> 8) as f32) / 16_777_216.0
}

/// Reflectance and emission of a surface, per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Material {
    /// Diffuse reflectance, 0 to 1.
    pub albedo: Vec3,
    /// Emitted radiance, in cd/m^2.
    pub emission: Vec3,
}

/// A triangle in world space, in metres; the counter-clockwise side is its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Positions of its corners.
    pub corners: [Vec3; 3],
    /// Index of its material.
    pub material: u32,
    /// Whether its back is a surface, too.
    pub double_sided: bool,
}

/// A material and its area, as seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialArea {
    /// Index of the material.
    pub material: u32,
    /// Sum of the areas of its surfaces, each projected onto the face, in units of a voxel's face.
    pub area: f32,
    /// The same as far as nothing in the voxel hides them.
    pub visible: f32,
}

/// The part of a triangle in a voxel.
struct SurfacePart<'a> {
    voxel: IVec3,
    overlap: TriangleOverlap,
    triangle: &'a Triangle,
    /// It is projected along the main axis of the triangle.
    part: Part,
}

/// The voxelised scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    /// Placement of the voxels.
    pub grid: VolumeGrid,
    /// Per voxel: bit x + 4 y + 16 z is set if sub-voxel (x, y, z) is occupied.
    pub masks: Vec<u64>,
    /// Per voxel and face: the packed surface, 0 without one.
    pub packed_surfaces: Vec<[u32; 6]>,
    /// Per voxel and face: the materials that face that side, each with the sum of its areas.
    pub material_areas: Vec<[Vec<MaterialArea>; 6]>,
}

/// Returns the bit of a sub-voxel in a mask.
pub fn sub_voxel_bit(sub_voxel: IVec3) -> u64 {
    1 << (sub_voxel.x + 4 * sub_voxel.y + 16 * sub_voxel.z)
}

/// The sub-voxels of a voxel, in the order of their bits.
pub(super) fn sub_voxels() -> impl Iterator<Item = IVec3> {
    (0..64).map(|bit| IVec3::new(bit % 4, bit / 4 % 4, bit / 16))
}

impl Voxels {
    /// Creates voxels without surfaces.
    pub fn empty(grid: VolumeGrid) -> Self {
        Self {
            grid,
            masks: vec![0; grid.len()],
            packed_surfaces: vec![[0; 6]; grid.len()],
            material_areas: vec![Default::default(); grid.len()],
        }
    }

    /// Voxelises triangles conservatively, in contrast to [`Voxels::from_points`]. Those without an area or that are
    /// not finite are skipped.
    pub fn new(grid: VolumeGrid, triangles: &[Triangle]) -> Self {
        let mut voxels = Self::empty(grid);
        let mut parts = Vec::new();
        for triangle in triangles {
            voxels.mark(triangle, &mut parts);
        }
        for part in &parts {
            voxels.add_part(part);
        }
        voxels
    }

    /// Marks the sub-voxels of a triangle, and collects its parts.
    fn mark<'a>(&mut self, triangle: &'a Triangle, parts: &mut Vec<SurfacePart<'a>>) {
        let corners = triangle.corners.map(|v| self.grid.to_grid(v));
        let Some(overlap) = TriangleOverlap::new(corners) else {
            return;
        };
        let last = self.grid.resolution as f32 - 1.0;
        let low = overlap.min.floor();
        let high = overlap.max.floor();
        if low.max_element() > last || high.min_element() < 0.0 {
            return;
        }
        let low = low.max(Vec3::ZERO).as_ivec3();
        let high = high.min(Vec3::splat(last)).as_ivec3();
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let voxel = IVec3::new(x, y, z);
                    let min = voxel.as_vec3();
                    if overlap.overlaps(min, 1.0)
                        && self.mark_in(voxel, |min, size| overlap.overlaps(min, size))
                    {
                        let mut part = part_in_voxel(overlap.corners, min, overlap.main_axis());
                        part.area = part.area.max(MIN_AREA);
                        parts.push(SurfacePart {
                            voxel,
                            overlap,
                            triangle,
                            part,
                        });
                    }
                }
            }
        }
    }

    /// Marks those sub-voxels of a voxel, by lowest corner and edge, that `is_in` accepts, and returns whether there are
    /// any.
    fn mark_in(&mut self, voxel: IVec3, is_in: impl Fn(Vec3, f32) -> bool) -> bool {
        let size = 1.0 / SUB_VOXELS as f32;
        let mut mask = 0;
        for sub in sub_voxels() {
            if is_in(voxel.as_vec3() + sub.as_vec3() * size, size) {
                mask |= sub_voxel_bit(sub);
            }
        }
        let index = self.grid.index(voxel).filter(|_| mask != 0);
        if let Some(index) = index {
            self.masks[index] |= mask;
        }
        index.is_some()
    }

    /// Adds a part of a triangle to the faces of its voxel, once all sub-voxels are marked.
    fn add_part(&mut self, part: &SurfacePart) {
        let Some(index) = self.grid.index(part.voxel) else {
            return;
        };
        let shares = [false, true].map(|is_back| self.visible_share(index, part, is_back));
        let (overlap, triangle) = (&part.overlap, part.triangle);
        for (face, direction) in FACES.into_iter().enumerate() {
            let cosine = overlap.normal.dot(direction);
            if cosine > MIN_FACE_COSINE || (triangle.double_sided && -cosine > MIN_FACE_COSINE) {
                let normal = overlap.normal * cosine.signum();
                let areas = [part.part.area, shares[usize::from(cosine < 0.0)]];
                let height = normal.dot(overlap.corners[0] - part.voxel.as_vec3() - 0.5);
                let plane = (normal, height);
                self.add_face(index, face, areas, cosine, plane, triangle.material);
            }
        }
    }

    /// The share of the columns of a part in which no sub-voxel of its voxel is in front of the surface: ground under a
    /// floor has no colour that shows.
    fn visible_share(&self, index: usize, part: &SurfacePart, is_back: bool) -> f32 {
        let axis = part.overlap.main_axis();
        let [u_axis, v_axis] = [(axis + 1) % 3, (axis + 2) % 3];
        let edge = SUB_VOXELS as f32;
        let point = edge * (part.overlap.corners[0] - part.voxel.as_vec3());
        let middle = edge * part.part.centroid;
        let half = 0.5 * edge * part.part.size;
        let most = Vec2::splat(edge - 1.0);
        let low = (middle - half + INWARDS).floor().clamp(Vec2::ZERO, most);
        let high = ((middle + half - INWARDS).ceil() - 1.0).clamp(low, most);
        let normal = part.overlap.normal;
        let slope = Vec2::new(normal[u_axis], normal[v_axis]) / normal[axis];
        let reach = 0.5 * slope.abs().element_sum();
        let is_forward = (normal[axis] > 0.0) != is_back;
        let mut visible = 0;
        let (low, high) = (low.as_ivec2(), high.as_ivec2());
        for v in low.y..=high.y {
            for u in low.x..=high.x {
                let at = Vec2::new(u as f32, v as f32) + 0.5;
                let depth = point[axis] - slope.dot(at - Vec2::new(point[u_axis], point[v_axis]));
                let is_ahead = |d: i32| {
                    if is_forward {
                        d as f32 > (depth + reach).floor()
                    } else {
                        (d as f32) < (depth - reach).floor()
                    }
                };
                let is_occupied = |d: i32| {
                    let mut sub = IVec3::ZERO;
                    (sub[u_axis], sub[v_axis], sub[axis]) = (u, v, d);
                    self.masks[index] & sub_voxel_bit(sub) != 0
                };
                let is_hidden = (0..SUB_VOXELS).any(|d| is_ahead(d) && is_occupied(d));
                visible += u32::from(!is_hidden);
            }
        }
        let columns = (high - low + 1).element_product();
        (visible as f32 / columns as f32).max(LEAST_SHARE)
    }

    /// Adds an area of a surface to a face of a voxel, and its share that shows. The plane is a normal, and the distance
    /// from the voxel's centre along it.
    fn add_face(
        &mut self,
        index: usize,
        face: usize,
        [area, share]: [f32; 2],
        cosine: f32,
        (normal, height): (Vec3, f32),
        material: u32,
    ) {
        let packed = &mut self.packed_surfaces[index][face];
        *packed = pack_surface(area, cosine, normal, height).max(*packed);
        let all = &mut self.material_areas[index][face];
        let area = area * cosine.abs();
        match all.iter_mut().find(|one| one.material == material) {
            Some(one) => {
                one.area += area;
                one.visible += area * share;
            }
            None => all.push(MaterialArea {
                material,
                area,
                visible: area * share,
            }),
        }
    }

    /// Returns what a voxel looks like from the side of a face: the mean over the area, with the emission scaled by the
    /// share of the sub-voxels that emits it.
    pub fn face_material(&self, index: usize, face: usize, materials: &[Material]) -> Material {
        let (area, mut mean) = self.mean_material(index, face, materials);
        if mean.emission != Vec3::ZERO {
            mean.emission *= self.emitting_share(index, face, area, mean.emission, materials);
        }
        mean
    }

    /// Sum of the areas that face a side, in units of a voxel's face, and the mean material.
    fn mean_material(&self, index: usize, face: usize, materials: &[Material]) -> (f32, Material) {
        let mut area = 0.0;
        let mut sum = Material::default();
        for part in &self.material_areas[index][face] {
            let material = materials.get(part.material as usize).copied();
            let material = material.unwrap_or_default();
            // The power of what emits is that of all its area.
            let part = if material.emission == Vec3::ZERO {
                part.visible
            } else {
                part.area
            };
            area += part;
            sum.albedo += part * material.albedo;
            sum.emission += part * material.emission;
        }
        if area > 0.0 {
            sum.albedo /= area;
            sum.emission /= area;
        }
        (area, sum)
    }

    /// The area of a face's surfaces over that of the exposed sub-voxels: rays see whole sub-voxels, and the power of
    /// what fills only a part of them is to be right.
    ///
    /// A tilted surface goes on in the voxels in front and behind, and its parts hide each other's sub-voxels. So the
    /// sums include these voxels, as far as they emit alike. The share is at most 1: where another wall hides its
    /// sub-voxels, a surface shines with its own radiance. Where the area exceeds that of the face there are layers, such
    /// as a picture on a wall: up to half of them are taken to be hidden, so that the share is at most 2.
    fn emitting_share(
        &self,
        index: usize,
        face: usize,
        area: f32,
        emission: Vec3,
        materials: &[Material],
    ) -> f32 {
        let voxel = self.grid.voxel(index);
        let own = emission.element_sum();
        let (mut areas, mut columns) = (0.0, 0.0);
        for distance in -CONTINUATION..=CONTINUATION {
            let Some(other) = self.grid.index(voxel + distance * FACE_STEPS[face]) else {
                continue;
            };
            let (area, mean) = self.mean_material(other, face, materials);
            let emission = mean.emission.element_sum();
            let alike = emission.min(own) / emission.max(own);
            areas += alike * area;
            columns += alike * self.exposed_columns(other, face);
        }
        let exposed = columns / (SUB_VOXELS * SUB_VOXELS) as f32;
        (areas / exposed.max(1e-9)).min(area.clamp(1.0, 2.0))
    }

    /// The area of the sub-voxels that are exposed towards a face, in sub-voxels, without what is in front of their sides.
    fn exposed_columns(&self, index: usize, face: usize) -> f32 {
        let base = self.grid.voxel(index) * SUB_VOXELS;
        sub_voxels()
            .map(|sub| base + sub)
            .filter(|sub| self.is_occupied(*sub) && self.is_outermost(*sub, FACE_STEPS[face]))
            .map(|sub| {
                self.filled(index, sub, (face / 2 + 1) % 3)
                    * self.filled(index, sub, (face / 2 + 2) % 3)
            })
            .sum()
    }

    /// The share of a sub-voxel between its two sides along an axis.
    fn filled(&self, index: usize, sub_voxel: IVec3, axis: usize) -> f32 {
        let middle = self.grid.voxel(index).as_vec3() + 0.5;
        let center = (sub_voxel.as_vec3() + 0.5) / SUB_VOXELS as f32 - middle;
        let reach = 0.5 / SUB_VOXELS as f32;
        let extent = |face: usize| {
            let packed = self.packed_surfaces[index][face];
            let plane = Plane::new(packed);
            let is_side = packed != 0
                && plane.crosses(center, 0.0)
                && self.is_outermost(sub_voxel, FACE_STEPS[face]);
            if is_side {
                SINK - plane.height_of(center)
            } else {
                reach
            }
        };
        ((extent(2 * axis) + extent(2 * axis + 1)) / (2.0 * reach)).max(0.0)
    }

    /// Returns whether a sub-voxel is occupied, counted from the volume's lowest corner; none is outside.
    pub fn is_occupied(&self, sub_voxel: IVec3) -> bool {
        self.grid
            .index(sub_voxel.div_euclid(IVec3::splat(SUB_VOXELS)))
            .is_some_and(|i| {
                self.masks[i] & sub_voxel_bit(sub_voxel.rem_euclid(IVec3::splat(SUB_VOXELS))) != 0
            })
    }

    /// Returns whether an occupied sub-voxel is the outermost one of its voxel in a direction, and the
    /// sub-voxel in front of it in the next voxel is empty.
    pub fn is_outermost(&self, sub_voxel: IVec3, step: IVec3) -> bool {
        let voxel = sub_voxel.div_euclid(IVec3::splat(SUB_VOXELS));
        let mut at = sub_voxel + step;
        while at.div_euclid(IVec3::splat(SUB_VOXELS)) == voxel {
            if self.is_occupied(at) {
                return false;
            }
            at += step;
        }
        !self.is_occupied(at)
    }

    /// Voxelises triangles by this number of random points on each, of which each stands for an equal part of the area;
    /// those without an area or that are not finite are skipped.
    pub fn from_points(grid: VolumeGrid, triangles: &[Triangle], points: u32) -> Self {
        let mut voxels = Self::empty(grid);
        let mut parts = Vec::new();
        for (number, triangle) in (0..).zip(triangles) {
            let [a, b, c] = triangle.corners.map(|corner| grid.to_grid(corner));
            let Some(overlap) = TriangleOverlap::new([a, b, c]) else {
                continue;
            };
            let area = 0.5 * (b - a).cross(c - a).length() / points as f32;
            for i in 0..points {
                let r = random(UVec3::new(0, number, i));
                let root = r.x.sqrt();
                let point = a * (1.0 - root) + b * ((1.0 - r.y) * root) + c * (r.y * root);
                let voxel = (point - overlap.normal * SINK).floor().as_ivec3();
                if voxels.mark_in(voxel, |min, size| overlap.crosses_plane(min, size)) {
                    let axis = overlap.main_axis();
                    let from_corner = point - overlap.normal * SINK - voxel.as_vec3();
                    let part = Part {
                        area,
                        centroid: Vec2::new(
                            from_corner[(axis + 1) % 3],
                            from_corner[(axis + 2) % 3],
                        ),
                        size: Vec2::splat((area * overlap.normal[axis].abs()).sqrt()),
                    };
                    parts.push(SurfacePart {
                        voxel,
                        overlap,
                        triangle,
                        part,
                    });
                }
            }
        }
        for part in &parts {
            voxels.add_part(part);
        }
        voxels
    }

    /// Marks what a camera sees at a pixel: the sub-voxels around the position that its plane crosses, and the faces that
    /// the normal turns to, unless they have a surface of a triangle. `position` is in metres.
    pub fn mark_visible(&mut self, position: Vec3, normal: Vec3, material: u32) {
        let point = self.grid.to_grid(position) - normal * SINK;
        let voxel = point.floor();
        let Some(index) = self.grid.index(voxel.as_ivec3()) else {
            return;
        };
        let local = (point - voxel) * SUB_VOXELS as f32;
        let own = local.floor().as_ivec3();
        let reach = 0.5 * normal.abs().element_sum();
        for sub in sub_voxels() {
            let is_near = (sub - own).abs().max_element() <= REACH;
            if is_near && normal.dot(sub.as_vec3() + 0.5 - local).abs() <= reach {
                self.masks[index] |= sub_voxel_bit(sub);
            }
        }
        for (face, direction) in FACES.into_iter().enumerate() {
            let cosine = normal.dot(direction);
            if cosine > MIN_FACE_COSINE {
                let plane = (normal, normal.dot(point - voxel - 0.5));
                self.add_face(index, face, [VISIBLE_AREA, 1.0], cosine, plane, material);
            }
        }
    }
}

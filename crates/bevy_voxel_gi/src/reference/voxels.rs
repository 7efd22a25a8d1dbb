//! Voxelisation of triangles (thesis 6.4 and 6.5).
//!
//! A voxel stores which of its 4 x 4 x 4 sub-voxels triangles overlap, and for each of its six faces the
//! normal of the largest surface that faces that side, and the areas of all materials there (6.5.2, 6.5.3: a single
//! average would mix the two sides of a wall).

use super::{
    clip::area_in_voxel,
    grid::{FACE_STEPS, FACES, VolumeGrid},
    overlap::TriangleOverlap,
    packed_surface::{MIN_FACE_COSINE, pack_surface},
};
use glam::{IVec3, Vec3};

/// Number of sub-voxels along an edge of a voxel.
pub const SUB_VOXELS: i32 = 4;

/// Least area of a triangle in a voxel that it overlaps, in units of a voxel's face: it may only touch it.
pub const MIN_AREA: f32 = 1.0 / 65_536.0;

/// Number of voxels in front of a face and behind in which a tilted surface is taken to go on.
const CONTINUATION: i32 = 2;

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
        for triangle in triangles {
            voxels.add(triangle);
        }
        voxels
    }

    fn add(&mut self, triangle: &Triangle) {
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
                    if overlap.overlaps(voxel.as_vec3(), 1.0) {
                        let overlaps = |min, size| overlap.overlaps(min, size);
                        let area = area_in_voxel(overlap.corners, voxel.as_vec3());
                        self.add_to(voxel, &overlap, triangle, area.max(MIN_AREA), overlaps);
                    }
                }
            }
        }
    }

    /// Adds an area of a triangle to a voxel, in those of its sub-voxels, by lowest corner and edge, that `is_in`
    /// accepts.
    pub(super) fn add_to(
        &mut self,
        voxel: IVec3,
        overlap: &TriangleOverlap,
        triangle: &Triangle,
        area: f32,
        is_in: impl Fn(Vec3, f32) -> bool,
    ) {
        let size = 1.0 / SUB_VOXELS as f32;
        let mut mask = 0;
        for bit in 0..64 {
            let sub = IVec3::new(bit % 4, bit / 4 % 4, bit / 16);
            if is_in(voxel.as_vec3() + sub.as_vec3() * size, size) {
                mask |= 1 << bit;
            }
        }
        let Some(index) = self.grid.index(voxel).filter(|_| mask != 0) else {
            return;
        };
        self.masks[index] |= mask;
        for (face, direction) in FACES.into_iter().enumerate() {
            let cosine = overlap.normal.dot(direction);
            if cosine > MIN_FACE_COSINE || (triangle.double_sided && -cosine > MIN_FACE_COSINE) {
                let normal = overlap.normal * cosine.signum();
                self.add_face(index, face, area, cosine, normal, triangle.material);
            }
        }
    }

    /// Adds an area of a surface to a face of a voxel.
    pub(super) fn add_face(
        &mut self,
        index: usize,
        face: usize,
        area: f32,
        cosine: f32,
        normal: Vec3,
        material: u32,
    ) {
        let packed = &mut self.packed_surfaces[index][face];
        *packed = pack_surface(area, cosine, normal).max(*packed);
        let all = &mut self.material_areas[index][face];
        let area = area * cosine.abs();
        match all.iter_mut().find(|one| one.material == material) {
            Some(one) => one.area += area,
            None => all.push(MaterialArea { material, area }),
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
            area += part.area;
            sum.albedo += part.area * material.albedo;
            sum.emission += part.area * material.emission;
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
            columns += alike * self.exposed_columns(other, face) as f32;
        }
        let exposed = columns / (SUB_VOXELS * SUB_VOXELS) as f32;
        (areas / exposed).min(area.clamp(1.0, 2.0))
    }

    /// Number of the columns of sub-voxels towards a face whose outermost sub-voxel is exposed.
    fn exposed_columns(&self, index: usize, face: usize) -> usize {
        let base = self.grid.voxel(index) * SUB_VOXELS;
        (0..64)
            .map(|bit| base + IVec3::new(bit % 4, bit / 4 % 4, bit / 16))
            .filter(|sub| self.is_occupied(*sub) && self.is_outermost(*sub, FACE_STEPS[face]))
            .count()
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
}

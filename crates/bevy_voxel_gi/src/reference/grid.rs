//! Placement and indexing of the voxels.

use glam::{IVec3, Vec3};

/// Normals of a voxel's faces, in the order of everything that is stored per face.
pub const FACES: [Vec3; 6] = [
    Vec3::X,
    Vec3::NEG_X,
    Vec3::Y,
    Vec3::NEG_Y,
    Vec3::Z,
    Vec3::NEG_Z,
];

/// [`FACES`] in whole voxels.
pub const FACE_STEPS: [IVec3; 6] = [
    IVec3::X,
    IVec3::NEG_X,
    IVec3::Y,
    IVec3::NEG_Y,
    IVec3::Z,
    IVec3::NEG_Z,
];

/// A cube of cubic voxels in world space.
///
/// Grid coordinates count voxels from its lowest corner: voxel (x, y, z) is the cube from (x, y, z) to
/// (x + 1, y + 1, z + 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeGrid {
    /// Lowest corner, in metres.
    pub min: Vec3,
    /// Edge of a voxel, in metres, above 0.
    pub voxel_size: f32,
    /// Number of voxels along an edge, at least 1 (the plugin uses 8 to 128).
    pub resolution: u32,
}

impl VolumeGrid {
    /// Creates the smallest volume around a box that leaves at least one voxel free on each side.
    ///
    /// `resolution` is at least 3.
    pub fn around(min: Vec3, max: Vec3, resolution: u32) -> Self {
        let voxel_size = (max - min).max_element() / (resolution - 2) as f32;
        let half = 0.5 * voxel_size * resolution as f32;
        Self {
            min: 0.5 * (min + max) - half,
            voxel_size,
            resolution,
        }
    }

    /// Returns the number of voxels.
    pub fn len(&self) -> usize {
        (self.resolution as usize).pow(3)
    }

    /// Returns `false` for any valid volume, as it has at least one voxel.
    pub fn is_empty(&self) -> bool {
        self.resolution == 0
    }

    /// Returns the index of a voxel in everything stored per voxel, x fastest; `None` outside the volume.
    pub fn index(&self, voxel: IVec3) -> Option<usize> {
        let r = self.resolution as i32;
        let inside = voxel.cmpge(IVec3::ZERO).all() && voxel.cmplt(IVec3::splat(r)).all();
        inside.then(|| (voxel.x + r * (voxel.y + r * voxel.z)) as usize)
    }

    /// Returns the voxel at an index, the inverse of [`VolumeGrid::index`].
    pub fn voxel(&self, index: usize) -> IVec3 {
        let (i, r) = (index as i32, self.resolution as i32);
        IVec3::new(i % r, i / r % r, i / (r * r))
    }

    /// Returns a number of a voxel by its place in the world: it stays the same where a volume follows something.
    pub fn seed_in_world(&self, voxel: IVec3) -> u32 {
        let corner = (self.min / self.voxel_size + 0.5).floor().as_ivec3();
        let place = (voxel + corner).as_uvec3();
        let rows = place.y.wrapping_add(place.z.wrapping_mul(977));
        place.x.wrapping_add(rows.wrapping_mul(977))
    }

    /// Returns the indices of the voxels whose centres are around a position in grid coordinates, with their weights in
    /// trilinear interpolation, clamped at the border.
    pub fn around_position(&self, position: Vec3) -> impl Iterator<Item = (usize, f32)> {
        let last = self.resolution as f32 - 1.0;
        let p = (position - 0.5).clamp(Vec3::ZERO, Vec3::splat(last));
        let low = p.floor();
        let f = p - low;
        (0..8).filter_map(move |corner| {
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let weights = Vec3::select(step.cmpeq(IVec3::ONE), f, 1.0 - f);
            let index = self.index(low.as_ivec3() + step)?;
            Some((index, weights.element_product()))
        })
    }

    /// Converts world to grid coordinates.
    pub fn to_grid(&self, world: Vec3) -> Vec3 {
        (world - self.min) / self.voxel_size
    }

    /// Converts grid to world coordinates.
    pub fn to_world(&self, grid: Vec3) -> Vec3 {
        self.min + grid * self.voxel_size
    }
}

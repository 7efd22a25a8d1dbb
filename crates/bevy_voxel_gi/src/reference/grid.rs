//! Where the voxels are.

use glam::{IVec3, Vec3};

/// The six directions a voxel's faces look in, and the order of everything stored per face.
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

/// A cube of cubic voxels in the world.
///
/// Grid coordinates are voxels from its lowest corner: voxel (x, y, z) is the cube from (x, y, z) to
/// (x + 1, y + 1, z + 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeGrid {
    /// Lowest corner, in metres.
    pub min: Vec3,
    /// Edge of a voxel, in metres, above 0.
    pub voxel_size: f32,
    /// Voxels along an edge, 1 or more (8 to 128 in use).
    pub resolution: u32,
}

impl VolumeGrid {
    /// The smallest volume around a box that leaves at least one voxel free on each side.
    ///
    /// `resolution` is 3 or more.
    pub fn around(min: Vec3, max: Vec3, resolution: u32) -> Self {
        let voxel_size = (max - min).max_element() / (resolution - 2) as f32;
        let half = 0.5 * voxel_size * resolution as f32;
        Self {
            min: 0.5 * (min + max) - half,
            voxel_size,
            resolution,
        }
    }

    /// How many voxels there are.
    pub fn len(&self) -> usize {
        (self.resolution as usize).pow(3)
    }

    /// Never: a volume has a voxel.
    pub fn is_empty(&self) -> bool {
        self.resolution == 0
    }

    /// Place of a voxel in everything stored per voxel, x fastest; None outside the volume.
    pub fn index(&self, voxel: IVec3) -> Option<usize> {
        let r = self.resolution as i32;
        let inside = voxel.cmpge(IVec3::ZERO).all() && voxel.cmplt(IVec3::splat(r)).all();
        inside.then(|| (voxel.x + r * (voxel.y + r * voxel.z)) as usize)
    }

    /// The voxel at a place, the inverse of [`VolumeGrid::index`].
    pub fn voxel(&self, index: usize) -> IVec3 {
        let (i, r) = (index as i32, self.resolution as i32);
        IVec3::new(i % r, i / r % r, i / (r * r))
    }

    /// World to grid coordinates.
    pub fn to_grid(&self, world: Vec3) -> Vec3 {
        (world - self.min) / self.voxel_size
    }

    /// Grid to world coordinates.
    pub fn to_world(&self, grid: Vec3) -> Vec3 {
        self.min + grid * self.voxel_size
    }
}

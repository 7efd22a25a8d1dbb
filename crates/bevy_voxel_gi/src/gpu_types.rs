//! The types that Rust and the shaders share. Keep in sync with `shaders/gpu_types.wesl`, which has the same fields
//! and documents them.

use bevy::{prelude::*, render::render_resource::ShaderType};
use bytemuck::{Pod, Zeroable};

/// Greatest number of levels that light pixels.
pub(crate) const MAX_LIT_LEVELS: usize = 8;
/// Greatest number of levels.
pub(crate) const MAX_LEVELS: usize = MAX_LIT_LEVELS + 3;

/// A cube of voxels: a volume, or a cascade of one.
#[derive(ShaderType, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Level {
    pub corner: Vec3,
    pub voxel_size: f32,
    pub sky_zenith: Vec3,
    pub sky_horizon: Vec3,
    pub sky_map_share: f32,
    pub sky_ground: Vec3,
}

/// The uniform of all passes: the placement of the levels, and the settings.
#[derive(ShaderType, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Volume {
    pub levels: [Level; MAX_LEVELS],
    pub resolution: u32,
    pub level_count: u32,
    pub lit_level_count: u32,
    pub light_count: u32,
    pub storage_scale: f32,
    pub exposure: f32,
    pub rays: u32,
    pub shadow_samples: u32,
    pub max_distance: f32,
    pub phase: u32,
    pub interval: u32,
    pub flags: u32,
    pub round: u32,
    pub points_per_triangle: u32,
    pub empty_interval: u32,
    pub blend: f32,
    pub emission_scale: f32,
    pub voxel_capacity: u32,
    pub frame: u32,
}

pub(crate) const FLAG_FEEDBACK: u32 = 1;
pub(crate) const FLAG_WEIGHTED: u32 = 2;
pub(crate) const FLAG_CHANGING: u32 = 4;
pub(crate) const FLAG_MEAN: u32 = 8;
pub(crate) const FLAG_HELD: u32 = 16;

#[derive(ShaderType, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Light {
    pub position: Vec3,
    pub kind: u32,
    pub color: Vec3,
    pub inverse_range_squared: f32,
    pub direction: Vec3,
    pub spot_scale: f32,
    pub half_width: Vec3,
    pub spot_offset: f32,
    pub half_height: Vec3,
    pub near: f32,
    pub tile_first: u32,
    pub tile_size: u32,
    pub tile_address: u32,
}

impl Light {
    /// Its numbers, but for the tile of its texture: floats by their bits.
    pub fn words(&self) -> [u32; 20] {
        let vectors = [
            self.position,
            self.color,
            self.direction,
            self.half_width,
            self.half_height,
        ];
        let [position, color, direction, width, height] = vectors.map(|v| v.to_array());
        let floats = std::iter::once(self.inverse_range_squared)
            .chain(position)
            .chain(color)
            .chain(direction)
            .chain([self.spot_scale, self.spot_offset])
            .chain(width)
            .chain(height)
            .chain([self.near]);
        let mut words = [self.kind; 20];
        for (word, float) in words[1..].iter_mut().zip(floats) {
            *word = float.to_bits();
        }
        words
    }
}

pub(crate) const LIGHT_DIRECTIONAL: u32 = 0;
pub(crate) const LIGHT_POINT: u32 = 1;
pub(crate) const LIGHT_SPOT: u32 = 2;
pub(crate) const LIGHT_RECT: u32 = 3;

/// A mesh to voxelise.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MeshInstance {
    pub world_from_local: Mat4,
    pub uv_range_0: Vec4,
    pub uv_range_1: Vec4,
    pub position_center: Vec3,
    pub flags: u32,
    pub position_half_size: Vec3,
    pub material: u32,
    pub vertex_base: u32,
    pub vertex_stride: u32,
    pub position_offset: u32,
    pub color_offset: u32,
    pub uv_offsets: UVec2,
    pub joint_index_offset: u32,
    pub joint_weight_offset: u32,
    pub first_joint: u32,
    pub index_base: u32,
    pub index_size: u32,
    pub triangle_count: u32,
    pub morph_base: u32,
    pub vertex_count: u32,
    pub first_weights: u32,
    pub weight_count: u32,
}

impl MeshInstance {
    /// A bit for each level that it may reach into.
    pub fn levels(&self) -> u32 {
        self.flags >> MESH_LEVELS_SHIFT
    }
}

pub(crate) const MESH_SKINNED: u32 = 1;
pub(crate) const MESH_MIRRORED: u32 = 2;
pub(crate) const MESH_STRIP: u32 = 4;
pub(crate) const MESH_NOT_SHADOW_CASTER: u32 = 8;
pub(crate) const MESH_PACKED_POSITIONS: u32 = 16;
pub(crate) const MESH_PACKED_JOINT_WEIGHTS: u32 = 32;
pub(crate) const MESH_UVS: u32 = 64;
pub(crate) const MESH_PACKED_UVS: u32 = 256;
pub(crate) const MESH_COLORS: u32 = 1024;
pub(crate) const COLORS_FLOAT32: u32 = 0;
pub(crate) const COLORS_UNORM8: u32 = 2048;
pub(crate) const COLORS_FLOAT16: u32 = 4096;
pub(crate) const COLORS_UNORM16: u32 = 6144;
pub(crate) const MESH_LEVELS_SHIFT: u32 = 16;

/// Up to 64 triangles of a mesh.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MeshBatch {
    pub low: Vec3,
    pub instance: u32,
    pub high: Vec3,
    pub first_triangle: u32,
}

/// What has changed since the scene was voxelised last.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
pub(crate) struct Changes {
    pub moves: [IVec4; MAX_LEVELS],
    pub is_whole: u32,
}

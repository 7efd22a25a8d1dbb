//! The GPU buffers of the volume.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages},
        renderer::RenderDevice,
    },
};

use crate::{
    extract::placement::PlacedVolume,
    settings::{Solver, VoxelAlbedo, VoxelLight},
};

/// The settings that the sizes of the buffers depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BufferShape {
    pub voxels: u64,
    /// Only ambient occlusion is computed, so only occupancy is stored.
    pub occlusion_only: bool,
    /// Light is propagated from voxel to voxel.
    pub propagates: bool,
    /// Albedo is reprojected from cameras.
    pub reprojects_albedo: bool,
    /// Pixels test the visibility of voxels, and need the occupancy masks of sub-voxels.
    pub per_pixel: bool,
}

impl BufferShape {
    pub(crate) fn of(volume: &PlacedVolume) -> Self {
        let r = u64::from(volume.settings.resolution);
        let occlusion_only = matches!(volume.settings.light, VoxelLight::AmbientOcclusion { .. });
        Self {
            voxels: r * r * r * volume.levels.len() as u64,
            propagates: matches!(
                volume.settings.light,
                VoxelLight::GlobalIllumination {
                    solver: Solver::Propagate { .. },
                    ..
                }
            ),
            occlusion_only,
            per_pixel: volume.is_per_pixel(),
            reprojects_albedo: volume.settings.albedo == VoxelAlbedo::Reprojected
                && !occlusion_only,
        }
    }

    /// Whether the light of a frame continues in the next: propagation starts over in each frame.
    pub(crate) fn keeps_light(self) -> bool {
        !self.occlusion_only && !self.propagates
    }
}

/// Size in bytes of the largest buffer: that of irradiance, or that of the work with ambient occlusion.
pub(crate) fn largest_buffer(light: VoxelLight, resolution: u32, levels: u64) -> u64 {
    let bytes_per_voxel = match light {
        VoxelLight::GlobalIllumination { .. } => 96,
        VoxelLight::AmbientOcclusion { .. } => 28,
    };
    u64::from(resolution).pow(3) * levels * bytes_per_voxel
}

/// The buffers of the volume.
#[derive(Resource)]
pub(crate) struct VolumeBuffers {
    pub shape: BufferShape,
    /// 64 bits per voxel: the occupancy of its sub-voxels.
    pub masks: Buffer,
    /// Six words per voxel: the packed surface of each face. A stub for ambient occlusion.
    pub packed_surfaces: Buffer,
    /// Six times two words per voxel: radiance that leaves each face, as 16-bit floats. A stub for
    /// ambient occlusion.
    pub radiance: Buffer,
    /// Six times four words per voxel: irradiance of each face in this round, with the distance of its
    /// surface from the voxel's centre, and the mean over rounds with its weight, as 16-bit floats; or, with
    /// propagation, the light that has arrived, as 32-bit floats. A stub for ambient occlusion.
    pub irradiance: Buffer,
    /// Sixteen words per voxel each: propagated light before and after a step. Stubs without propagation.
    pub intensity: [Buffer; 2],
    /// Six words per voxel: reprojected albedo of each face. A stub without reprojection.
    pub reprojected_albedo: Buffer,
    /// The compacted work, surfaces first, then empty voxels: voxel index times 8 plus face.
    pub work_items: Buffer,
    /// The number of surfaces and of empty voxels, then the indirect dispatch arguments over them.
    pub counters: Buffer,
    /// The copy of these arguments that indirect dispatches read.
    pub indirect_args: Buffer,
}

impl VolumeBuffers {
    /// Size of `counters` in bytes.
    const COUNTERS_SIZE: u64 = Self::ARGS_OFFSET + Self::ARGS_SIZE;
    /// Byte offset of the indirect dispatch arguments in `counters`.
    pub(crate) const ARGS_OFFSET: u64 = 16;
    /// Size of the indirect dispatch arguments in bytes.
    pub(crate) const ARGS_SIZE: u64 = 48;
    /// Byte offsets of the indirect dispatch arguments: a workgroup for each surface, for each empty voxel,
    /// and for 64 surfaces.
    pub(crate) const SURFACE_ARGS: u64 = 0;
    pub(crate) const EMPTY_VOXEL_ARGS: u64 = 16;
    pub(crate) const SURFACE_THREAD_ARGS: u64 = 32;

    pub(crate) fn new(device: &RenderDevice, shape: BufferShape) -> Self {
        let buffer = |label: &'static str, size: u64, usage: BufferUsages| {
            device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size: size.max(16),
                usage,
                mapped_at_creation: false,
            })
        };
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let full = |bytes: u64| {
            if shape.occlusion_only {
                16
            } else {
                bytes * shape.voxels
            }
        };
        Self {
            shape,
            masks: buffer("voxel_gi_masks", 8 * shape.voxels, storage),
            packed_surfaces: buffer("voxel_gi_packed_surfaces", full(24), storage),
            radiance: buffer("voxel_gi_radiance", full(48), storage),
            intensity: ["voxel_gi_intensity_a", "voxel_gi_intensity_b"].map(|label| {
                let bytes = if shape.propagates {
                    64 * shape.voxels
                } else {
                    64
                };
                buffer(label, bytes, storage)
            }),
            irradiance: buffer("voxel_gi_irradiance", full(96), storage),
            reprojected_albedo: buffer(
                "voxel_gi_reprojected_albedo",
                if shape.reprojects_albedo {
                    full(24)
                } else {
                    16
                },
                storage,
            ),
            work_items: buffer("voxel_gi_work_items", 28 * shape.voxels, storage),
            counters: buffer("voxel_gi_counters", Self::COUNTERS_SIZE, storage),
            indirect_args: buffer(
                "voxel_gi_indirect_args",
                Self::ARGS_SIZE,
                BufferUsages::INDIRECT | BufferUsages::COPY_DST,
            ),
        }
    }

    /// Total size of the buffers in bytes, as allocated.
    pub(crate) fn bytes(&self) -> u64 {
        [
            &self.masks,
            &self.packed_surfaces,
            &self.radiance,
            &self.irradiance,
            &self.intensity[0],
            &self.intensity[1],
            &self.reprojected_albedo,
            &self.work_items,
            &self.counters,
            &self.indirect_args,
        ]
        .map(|buffer| buffer.size())
        .iter()
        .sum()
    }
}

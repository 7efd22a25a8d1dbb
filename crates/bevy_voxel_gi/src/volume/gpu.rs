//! The GPU buffers and uniforms of the volume.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, ShaderType, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::{
    STORAGE_SCALE,
    placement::{Level, MOST_LEVELS, PlacedVolume},
};
use crate::settings::{Bounces, Solver, VoxelAlbedo, VoxelLight, Voxelizer};

/// Keep in sync with `volume.wesl`, which documents the fields.
#[derive(ShaderType, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GpuLevel {
    corner: Vec3,
    voxel_size: f32,
    sky_zenith: Vec3,
    intensity: f32,
    sky_horizon: Vec3,
    sky_ground: Vec3,
}

impl GpuLevel {
    fn new(level: &Level, volume: &PlacedVolume) -> Self {
        let scaled = |color: LinearRgba| color.to_vec3() * STORAGE_SCALE;
        Self {
            corner: level.center - 0.5 * level.size,
            voxel_size: volume.voxel_size(level),
            sky_zenith: scaled(level.sky.zenith),
            intensity: level.intensity,
            sky_horizon: scaled(level.sky.horizon),
            sky_ground: scaled(level.sky.ground),
        }
    }
}

/// Keep in sync with `volume.wesl`, which documents the fields.
#[derive(ShaderType, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GpuVolume {
    pub levels: [GpuLevel; MOST_LEVELS],
    pub extent: Vec3,
    pub resolution: u32,
    pub center: Vec3,
    pub level_count: u32,
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
}

const FLAG_FEEDBACK: u32 = 1;
const FLAG_WEIGHTED: u32 = 2;
const FLAG_CHANGING: u32 = 4;

/// Number of rounds over which empty voxels are updated, one part in each: they light only meshes that
/// are not voxelised themselves.
pub(crate) const EMPTY_INTERVAL: u32 = 8;

impl GpuVolume {
    pub(crate) fn new(volume: &PlacedVolume, light_count: u32, frame: u32, blend: f32) -> Self {
        let settings = &volume.settings;
        let phase = frame % settings.update_interval;
        let (rays, max_distance, feedback) = match settings.light {
            VoxelLight::GlobalIllumination { solver, bounces } => {
                let rays = match solver {
                    Solver::Trace { rays } => rays,
                    Solver::Propagate { .. } => 0,
                };
                let feedback = rays > 0 && bounces == Bounces::Endless;
                (rays, f32::MAX, feedback)
            }
            VoxelLight::AmbientOcclusion { radius, rays } => (rays, radius, false),
        };
        // Without a mean over rounds the rays are the same in every frame.
        let (round, blend) = match settings.light {
            VoxelLight::AmbientOcclusion { .. } => (0, 1.0),
            VoxelLight::GlobalIllumination { .. } => (frame / settings.update_interval, blend),
        };
        let mut flags = 0;
        for (on, flag) in [(feedback, FLAG_FEEDBACK), (volume.patched, FLAG_WEIGHTED)] {
            if on {
                flags |= flag;
            }
        }
        let mut levels = [GpuLevel::default(); MOST_LEVELS];
        for (gpu, level) in levels.iter_mut().zip(&volume.levels) {
            *gpu = GpuLevel::new(level, volume);
        }
        let (center, extent) = volume.bounds();
        Self {
            levels,
            extent,
            resolution: settings.resolution,
            center,
            level_count: volume.levels.len() as u32,
            light_count,
            storage_scale: STORAGE_SCALE,
            exposure: volume.exposure,
            rays,
            shadow_samples: settings.shadow_samples,
            max_distance,
            phase,
            interval: settings.update_interval,
            flags,
            round,
            points_per_triangle: match settings.voxelizer {
                Voxelizer::Stochastic { points } => points,
                _ => 0,
            },
            empty_interval: EMPTY_INTERVAL,
            blend,
        }
    }

    /// Sets the flag of a scene in which something has changed lately.
    pub(crate) fn changing(mut self, is_changing: bool) -> Self {
        if is_changing {
            self.flags |= FLAG_CHANGING;
        }
        self
    }

    /// Updates all voxels in this frame.
    pub(crate) fn all_at_once(self) -> Self {
        Self {
            phase: 0,
            interval: 1,
            empty_interval: 1,
            ..self
        }
    }

    /// Sets whether the light of the previous pass is reflected again.
    pub(crate) fn with_feedback(mut self, feedback: bool) -> Self {
        self.flags &= !FLAG_FEEDBACK;
        self.flags |= if feedback { FLAG_FEEDBACK } else { 0 };
        self
    }
}

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
        Self {
            voxels: r * r * r * volume.levels.len() as u64,
            propagates: matches!(
                volume.settings.light,
                VoxelLight::GlobalIllumination {
                    solver: Solver::Propagate { .. },
                    ..
                }
            ),
            occlusion_only: matches!(volume.settings.light, VoxelLight::AmbientOcclusion { .. }),
            per_pixel: volume.is_per_pixel(),
            reprojects_albedo: volume.settings.albedo == VoxelAlbedo::Reprojected
                && !matches!(volume.settings.light, VoxelLight::AmbientOcclusion { .. }),
        }
    }
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
    /// Six times four words per voxel: irradiance of each face in this round, and the mean over rounds
    /// with its weight, as 16-bit floats; or, with propagation, the light that has arrived, as 32-bit
    /// floats. A stub for ambient occlusion.
    pub irradiance: Buffer,
    /// Sixteen words per voxel each: propagated light before and after a step. Stubs without propagation.
    pub intensity: [Buffer; 2],
    /// Six words per voxel: reprojected albedo of each face. A stub without reprojection.
    pub reprojected_albedo: Buffer,
    /// The compacted work, surfaces first, then empty voxels: voxel index times 8 plus face.
    pub work: Buffer,
    /// The number of surfaces and of empty voxels, then the indirect dispatch arguments over them.
    pub counters: Buffer,
    /// The copy of these arguments that indirect dispatches read.
    pub dispatch: Buffer,
}

impl VolumeBuffers {
    /// Size of `counters` in bytes.
    const COUNTERS: u64 = Self::SIZES + Self::DISPATCH;
    /// Byte offset of the indirect dispatch arguments in `counters`.
    pub(crate) const SIZES: u64 = 16;
    /// Size of the indirect dispatch arguments in bytes.
    pub(crate) const DISPATCH: u64 = 32;

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
            work: buffer("voxel_gi_work", 28 * shape.voxels, storage),
            counters: buffer("voxel_gi_counters", Self::COUNTERS, storage),
            dispatch: buffer(
                "voxel_gi_dispatch",
                Self::DISPATCH,
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
            &self.work,
            &self.counters,
            &self.dispatch,
        ]
        .map(|buffer| buffer.size())
        .iter()
        .sum()
    }
}

/// The uniforms of the volume.
#[derive(Resource, Default)]
pub(crate) struct VolumeUniforms {
    /// For the first bounce of a frame, and for the later ones.
    pub bounces: [UniformBuffer<GpuVolume>; 2],
}

impl VolumeUniforms {
    pub(crate) fn write(
        &mut self,
        volumes: [GpuVolume; 2],
        device: &RenderDevice,
        queue: &RenderQueue,
    ) {
        for (buffer, volume) in self.bounces.iter_mut().zip(volumes) {
            buffer.set(volume);
            buffer.write_buffer(device, queue);
        }
    }
}

//! The uniforms of the volume, and the lights.

use bevy::{
    prelude::*,
    render::{
        render_resource::{StorageBuffer, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
    },
};

use crate::{
    extract::{
        placement::{PlacedLevel, PlacedVolume},
        probe::STORAGE_SCALE,
    },
    gpu_types::{
        Changes, FLAG_CHANGING, FLAG_FEEDBACK, FLAG_HELD, FLAG_MEAN, FLAG_WEIGHTED, Level, Light,
        MAX_LEVELS, Volume,
    },
    settings::{Bounces, Solver, VoxelLight, Voxelizer},
};

/// Number of rounds over which empty voxels are updated, one part in each: they light only meshes that
/// are not voxelised themselves.
pub(super) const EMPTY_INTERVAL: u32 = 8;

/// The same of ambient occlusion, whose other rays are fewer.
const OCCLUSION_EMPTY_INTERVAL: u32 = 16;

/// What the passes read beside the buffers of the volume.
#[derive(Resource, Default)]
pub(crate) struct VolumeUniforms {
    /// For the first bounce of a frame, for the last of several, and for those between them.
    pub bounces: [UniformBuffer<Volume>; 3],
    /// What has changed since the scene was voxelised last.
    pub changes: UniformBuffer<Changes>,
    /// The lights of the scene, or one without light, as buffers cannot be empty.
    pub lights: StorageBuffer<Vec<Light>>,
}

/// The one of the uniforms for a bounce of so many in a frame.
pub(crate) fn uniform_of(bounce: u32, bounces: u32) -> usize {
    match bounce {
        0 => 0,
        last if last + 1 == bounces => 1,
        _ => 2,
    }
}

impl VolumeUniforms {
    pub(super) fn write(
        &mut self,
        frame: UniformFrame,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) {
        let first = frame.uniform();
        // All bounces of a frame but the first reflect the light of the one before.
        let between = Volume {
            flags: first.flags | FLAG_FEEDBACK,
            ..first
        };
        let last = Volume {
            flags: between.flags | FLAG_MEAN,
            ..first
        };
        let all = [first, last, between];
        for (buffer, volume) in self.bounces.iter_mut().zip(all) {
            buffer.set(volume);
            buffer.write_buffer(device, queue);
        }
        let lights = self.lights.get_mut();
        lights.clear();
        lights.extend_from_slice(frame.lights);
        if lights.is_empty() {
            lights.push(Light::default());
        }
        self.lights.write_buffer(device, queue);
    }
}

/// The values of a frame from which the uniforms are made.
#[derive(Clone, Copy)]
pub(super) struct UniformFrame<'a> {
    pub volume: &'a PlacedVolume,
    pub lights: &'a [Light],
    /// Number of bounces in the frame.
    pub bounces: u32,
    /// Number of the frame; see [`SettlingClock`](super::settling::SettlingClock).
    pub frame: u32,
    /// Blend factor of this frame in the mean that pixels read.
    pub blend: f32,
    /// Whether something has changed lately.
    pub is_changing: bool,
    /// Whether pixels keep the light that they have.
    pub is_held: bool,
    /// Unit of the emission of surfaces, in exposed units.
    pub emission_unit: f32,
    /// Whether levels have moved: then all voxels are updated.
    pub has_moved: bool,
    /// Number of voxels for which there is room.
    pub voxel_capacity: u32,
}

impl UniformFrame<'_> {
    fn uniform(&self) -> Volume {
        let settings = &self.volume.settings;
        let frame_bounces = self.bounces;
        let interval = settings.update_interval;
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
        let round = self.frame / interval;
        let empty_interval = match settings.light {
            VoxelLight::AmbientOcclusion { .. } => OCCLUSION_EMPTY_INTERVAL,
            VoxelLight::GlobalIllumination { .. } => EMPTY_INTERVAL,
        };
        let (phase, interval, empty_interval) = if self.has_moved {
            (0, 1, 1)
        } else {
            (self.frame % interval, interval, empty_interval)
        };
        let flags = [
            (feedback, FLAG_FEEDBACK),
            (frame_bounces == 1, FLAG_MEAN),
            (self.volume.patched, FLAG_WEIGHTED),
            (self.is_changing, FLAG_CHANGING),
            (self.is_held, FLAG_HELD),
        ];
        let mut levels = [Level::default(); MAX_LEVELS];
        for (level, placed) in levels.iter_mut().zip(&self.volume.levels) {
            *level = level_uniform(placed, self.volume);
        }
        Volume {
            levels,
            resolution: settings.resolution,
            level_count: self.volume.levels.len() as u32,
            lit_level_count: self.volume.lit().len() as u32,
            light_count: u32::try_from(self.lights.len()).unwrap_or(u32::MAX),
            storage_scale: STORAGE_SCALE,
            exposure: self.volume.exposure,
            rays,
            shadow_samples: settings.shadow_samples,
            max_distance,
            phase,
            interval,
            flags: flags
                .into_iter()
                .filter(|(is_on, _)| *is_on)
                .fold(0, |all, (_, flag)| all | flag),
            round,
            points_per_triangle: match settings.voxelizer {
                Voxelizer::Stochastic { points } => points,
                _ => 0,
            },
            empty_interval,
            blend: self.blend,
            voxel_capacity: self.voxel_capacity,
            emission_scale: STORAGE_SCALE * self.emission_unit / self.volume.exposure,
        }
    }
}

fn level_uniform(level: &PlacedLevel, volume: &PlacedVolume) -> Level {
    let scaled = |color: LinearRgba| color.to_vec3() * STORAGE_SCALE;
    Level {
        corner: level.center - 0.5 * level.size,
        voxel_size: volume.voxel_size(level),
        sky_zenith: scaled(level.sky.zenith),
        sky_horizon: scaled(level.sky.horizon),
        sky_map_share: f32::from(u8::from(level.sees_map)),
        sky_ground: scaled(level.sky.ground),
    }
}

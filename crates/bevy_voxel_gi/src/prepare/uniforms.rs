//! The uniforms of the volume, and the lights.

use bevy::{
    prelude::*,
    render::{
        render_resource::{StorageBuffer, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::{
    plan::FrameWork,
    settling::{Pace, SettlingClock},
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
    /// Writes the uniforms, of which the first is given, and the lights.
    pub(super) fn write(
        &mut self,
        first: Volume,
        lights: &[Light],
        device: &RenderDevice,
        queue: &RenderQueue,
    ) {
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
        let known = self.lights.get_mut();
        known.clear();
        known.extend_from_slice(lights);
        if known.is_empty() {
            known.push(Light::default());
        }
        self.lights.write_buffer(device, queue);
    }
}

/// The uniform of the first bounce of a frame, without what depends on lights, materials and buffers.
pub(super) fn first_uniform(
    volume: &PlacedVolume,
    work: &FrameWork,
    clock: &SettlingClock,
    pace: Pace,
) -> Volume {
    let settings = &volume.settings;
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
    let frame = clock.frame();
    let empty_interval = if settings.light.is_occlusion() {
        OCCLUSION_EMPTY_INTERVAL
    } else {
        EMPTY_INTERVAL
    };
    let flags = [
        (feedback, FLAG_FEEDBACK),
        (work.bounces == 1, FLAG_MEAN),
        (volume.patched, FLAG_WEIGHTED),
        (clock.is_changing(pace), FLAG_CHANGING),
        (work.is_held, FLAG_HELD),
    ];
    let mut levels = [Level::default(); MAX_LEVELS];
    for (level, placed) in levels.iter_mut().zip(&volume.levels) {
        *level = level_uniform(placed, volume);
    }
    Volume {
        levels,
        resolution: settings.resolution,
        level_count: volume.levels.len() as u32,
        lit_level_count: volume.lit().len() as u32,
        storage_scale: STORAGE_SCALE,
        exposure: volume.exposure,
        rays,
        shadow_samples: settings.shadow_samples,
        max_distance,
        phase: frame % pace.interval,
        interval: pace.interval,
        flags: flags
            .into_iter()
            .filter(|(is_on, _)| *is_on)
            .fold(0, |all, (_, flag)| all | flag),
        round: frame / pace.interval,
        points_per_triangle: match settings.voxelizer {
            Voxelizer::Stochastic { points } => points,
            _ => 0,
        },
        empty_interval,
        blend: clock.blend(pace),
        ..Volume::default()
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

//! Plans the work of a frame: none, once nothing has changed for as long as the light needs to settle.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    platform::hash::FixedHasher,
    prelude::*,
    render::{
        mesh::{RenderMesh, allocator::MeshAllocator},
        render_asset::RenderAssets,
        render_resource::{
            CachedComputePipelineId, PipelineCache, SpecializedComputePipelines, StorageBuffer,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::{
    gpu::{BufferShape, EMPTY_INTERVAL, GpuVolume, VolumeBuffers, VolumeUniforms},
    placement::{Level, MOST_LEVELS, PlacedVolume},
    scroll::{ScrollPipeline, ScrollWork},
};
use crate::{
    light::{
        LightWork,
        pipeline::{LightPipelineIds, LightPipelines},
    },
    report::{SharedReport, VoxelGiReport, VoxelGiState},
    scene::{
        extract::ExtractedScene,
        lights::{ExtractedLights, GpuLight},
        voxel_material::VoxelMaterial,
    },
    settings::{Bounces, Solver, VoxelLight},
    voxelize::{
        VoxelizeWork,
        instances::{self, hash_floats},
        pipeline::{VoxelizeKey, VoxelizePipeline, pipeline_for},
    },
};

/// The volume of this frame.
#[derive(Resource, Default)]
pub(crate) struct ExtractedVolume(pub Option<PlacedVolume>);

/// The work of this frame.
#[derive(Resource, Default)]
pub(crate) struct FramePlan {
    /// The pipeline of the voxeliser, if it is to run.
    pub voxelize: Option<CachedComputePipelineId>,
    /// The pipelines of light transport, if they are to run.
    pub light: Option<LightPipelineIds>,
    /// Number of bounces in this frame.
    pub bounces: u32,
    /// Number of propagation steps.
    pub iterations: u32,
    /// Whether levels have moved, which invalidates reprojected albedo.
    pub has_moved: bool,
    /// Number of frames computed since the light was last restarted. It determines the directions of
    /// rays, so the same change always settles to the same light.
    frame: u32,
    /// Hash of everything that the light depends on.
    fingerprint: u64,
    /// Number of frames since the light was last restarted: when the volume was created, or when
    /// something changed after a pause.
    since_new: u32,
    /// Number of frames since something changed.
    since_change: u32,
    /// Number of frames still to compute until the light has settled.
    unsettled: u32,
    /// Placement of the levels in the last frame.
    placement: Vec<Level>,
    /// The texture that holds the light.
    texture: Option<AssetId<Image>>,
}

/// Rounds in which endlessly reflected light settles, and the mean loses its share from before:
/// (7/8)⁴⁰ = 0.5%.
const SETTLE_ENDLESS: u32 = 40;

/// Rounds over which the light that pixels read is averaged.
const HISTORY: u32 = 8;

/// Rounds after a change in which light that differs much from its mean counts as changed, and not as
/// noise. Later than that it would bias the mean, as rare bright rays are missing from most rounds.
const CHANGING: u32 = 16;

/// Light settles after a multiple of this number of rounds, in each of which every voxel is updated
/// once: all ray sets have been traced, and changes that took a few frames to arrive settle to the same
/// light as those that arrived at once.
const SETTLE_STEP: u32 = 16;

/// Rounds after a restart in which bounces propagate before averaging starts.
const WARM_UP: u32 = 4;

impl FramePlan {
    fn idle(&mut self) {
        (self.voxelize, self.light) = (None, None);
    }

    /// Whether nothing changes any more.
    fn has_settled(&self, interval: u32) -> bool {
        self.unsettled == 0 && self.frame.is_multiple_of(SETTLE_STEP * interval)
    }

    /// Blend factor of this frame in the mean.
    fn blend(&self, interval: u32) -> f32 {
        let rounds = (self.since_new / interval + 1).saturating_sub(WARM_UP);
        1.0 / rounds.clamp(1, HISTORY) as f32
    }

    /// Whether any level has moved since the last frame.
    fn has_moved(&self, volume: &PlacedVolume) -> bool {
        self.placement.len() != volume.levels.len()
            || self
                .placement
                .iter()
                .zip(&volume.levels)
                .any(|(old, new)| old.center != new.center)
    }

    /// By how many of its voxels each level has moved since the last frame, if any has moved by whole
    /// voxels and the levels are the same.
    fn moved(&mut self, volume: &PlacedVolume) -> Option<[IVec4; MOST_LEVELS]> {
        let before = std::mem::replace(&mut self.placement, volume.levels.clone());
        let same = |(old, new): (&Level, &Level)| (old.owner, old.size) == (new.owner, new.size);
        if before.len() != volume.levels.len() || !before.iter().zip(&volume.levels).all(same) {
            return None;
        }
        let mut moves = [IVec4::ZERO; MOST_LEVELS];
        for ((place, old), new) in moves.iter_mut().zip(&before).zip(&volume.levels) {
            let voxels = (new.center - old.center) / volume.voxel_size(new);
            let whole = (voxels - voxels.round()).abs().max_element() < 1e-3;
            let near = voxels.abs().max_element() < 1e6;
            if whole && near {
                *place = voxels.round().as_ivec3().extend(0);
            }
        }
        (moves != [IVec4::ZERO; MOST_LEVELS]).then_some(moves)
    }

    /// Number of frames until nothing changes any more.
    fn time_to_settle(volume: &PlacedVolume) -> u32 {
        let bounces = match volume.settings.light {
            VoxelLight::GlobalIllumination {
                solver: Solver::Trace { .. },
                ..
            } => SETTLE_ENDLESS,
            _ => EMPTY_INTERVAL,
        };
        bounces * volume.settings.update_interval
    }
}

/// Plans the frame and creates its buffers and bind groups.
pub(crate) fn prepare_frame(
    mut commands: Commands,
    extracted: (
        Res<ExtractedVolume>,
        Res<ExtractedScene>,
        Res<ExtractedLights>,
    ),
    mut plan: ResMut<FramePlan>,
    buffers: Option<Res<VolumeBuffers>>,
    mut uniforms: ResMut<VolumeUniforms>,
    (allocator, meshes, images): (
        Res<MeshAllocator>,
        Res<RenderAssets<RenderMesh>>,
        Res<RenderAssets<GpuImage>>,
    ),
    (device, queue, cache): (Res<RenderDevice>, Res<RenderQueue>, Res<PipelineCache>),
    (voxelize, light, scrolling): (
        Res<VoxelizePipeline>,
        Res<LightPipelines>,
        Res<ScrollPipeline>,
    ),
    mut voxelizers: ResMut<SpecializedComputePipelines<VoxelizePipeline>>,
    mut lights: ResMut<SpecializedComputePipelines<LightPipelines>>,
    mut scrollers: ResMut<SpecializedComputePipelines<ScrollPipeline>>,
    report: Res<SharedReport>,
) {
    let plan = &mut *plan;
    plan.idle();
    commands.remove_resource::<ScrollWork>();
    let (volume, scene, sources) = &extracted;
    let Some(volume) = &volume.0 else {
        if buffers.is_some() {
            commands.remove_resource::<VolumeBuffers>();
            commands.remove_resource::<VoxelizeWork>();
            commands.remove_resource::<LightWork>();
            *plan = FramePlan::default();
        }
        report.set(VoxelGiReport::default());
        return;
    };
    let shape = BufferShape::of(volume);
    let Some(texture) = images.get(&volume.texture) else {
        return;
    };
    let fresh = buffers
        .as_ref()
        .is_none_or(|buffers| buffers.shape != shape)
        || plan.texture != Some(volume.texture.id());
    let key = VoxelizeKey::new(volume.settings.voxelizer, shape.occlusion_only);
    let voxelizer = pipeline_for(key, &voxelize, &mut voxelizers, &cache);
    let interval = volume.settings.update_interval;
    let light_ids = light.ids(shape, &mut lights, &cache);
    // Propagation starts over in each frame.
    let keeps_light = !shape.occlusion_only && !shape.propagates;
    let scroller = keeps_light.then(|| scrollers.specialize(&cache, &scrolling, ()));
    let is_ready = |id| cache.get_compute_pipeline(id).is_some();
    if !light_ids.are_ready(&cache) || !is_ready(voxelizer) || !scroller.is_none_or(is_ready) {
        return;
    }
    let instances = instances::collect(scene, volume, &allocator, &meshes, &device);
    let fingerprint = fingerprint(instances.fingerprint, volume, &sources.0, &scene.surfaces);
    if fresh {
        *plan = FramePlan::default();
        plan.texture = Some(volume.texture.id());
    }
    if fresh || fingerprint != plan.fingerprint {
        plan.fingerprint = fingerprint;
        // A volume that only moves keeps its light.
        if plan.since_change > HISTORY * interval && !plan.has_moved(volume) {
            plan.since_new = 0;
            plan.frame = 0;
        }
        plan.since_change = 0;
        plan.unsettled = FramePlan::time_to_settle(volume);
    }
    let made = fresh.then(|| VolumeBuffers::new(&device, shape));
    let Some(buffers) = made.as_ref().or(buffers.as_deref()) else {
        return;
    };
    report.set(VoxelGiReport {
        state: if plan.has_settled(interval) && volume.settings.pause_when_settled {
            VoxelGiState::Settled
        } else {
            VoxelGiState::Running
        },
        memory: buffers.bytes() + texture_bytes(texture),
        triangles: instances.triangles,
        receiver_patched: volume.patched,
    });
    if plan.has_settled(interval) && volume.settings.pause_when_settled {
        return;
    }
    plan.unsettled = plan.unsettled.saturating_sub(1);
    let light_count = u32::try_from(sources.0.len()).unwrap_or(u32::MAX);
    let moved = plan.moved(volume);
    let first = GpuVolume::new(volume, light_count, plan.frame, plan.blend(interval))
        .changing(plan.since_change < CHANGING * interval);
    uniforms.write(
        [first, first.with_feedback(true)].map(|gpu| match moved {
            Some(_) => gpu.all_at_once(),
            None => gpu,
        }),
        &device,
        &queue,
    );
    plan.has_moved = moved.is_some();
    plan.frame = plan.frame.wrapping_add(1);
    plan.since_new = plan.since_new.saturating_add(1);
    plan.since_change = plan.since_change.saturating_add(1);
    plan.iterations = match volume.settings.light {
        VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { iterations },
            ..
        } => iterations,
        _ => 0,
    };
    plan.bounces = match volume.settings.light {
        VoxelLight::GlobalIllumination {
            bounces: Bounces::Count(count),
            ..
        } => count,
        _ => 1,
    };
    let voxelize_work = VoxelizeWork::new(
        &instances,
        &scene.joints,
        &uniforms,
        buffers,
        &voxelize,
        &cache,
        &device,
        &queue,
    );
    let light_work = LightWork::new(
        &storage(&scene.surfaces, &VoxelMaterial::NEUTRAL, &device, &queue),
        &storage(&sources.0, &GpuLight::default(), &device, &queue),
        texture,
        &uniforms,
        buffers,
        &light,
        &cache,
        &device,
    );
    let (Some(voxelize_work), Some(light_work)) = (voxelize_work, light_work) else {
        return;
    };
    if let (Some(voxels), Some(scroller)) = (moved, scroller)
        && let Some(work) = ScrollWork::new(
            voxels,
            &uniforms,
            buffers,
            (&scrolling, scroller),
            &cache,
            &device,
            &queue,
        )
    {
        commands.insert_resource(work);
    }
    plan.voxelize = Some(voxelizer);
    plan.light = Some(light_ids);
    commands.insert_resource(voxelize_work);
    commands.insert_resource(light_work);
    if let Some(made) = made {
        commands.insert_resource(made);
    }
}

/// A buffer of these items, or of `otherwise` alone, as buffers cannot be empty.
fn storage<
    T: bevy::render::render_resource::ShaderType
        + bevy::render::render_resource::ShaderSize
        + bevy::render::render_resource::encase::internal::WriteInto
        + Clone,
>(
    items: &[T],
    otherwise: &T,
    device: &RenderDevice,
    queue: &RenderQueue,
) -> StorageBuffer<Vec<T>> {
    let mut buffer = StorageBuffer::from(if items.is_empty() {
        vec![otherwise.clone()]
    } else {
        items.to_vec()
    });
    buffer.write_buffer(device, queue);
    buffer
}

fn texture_bytes(texture: &GpuImage) -> u64 {
    let size = texture.texture_descriptor.size;
    8 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
}

/// Hash of everything that the light depends on.
fn fingerprint(
    meshes: u64,
    volume: &PlacedVolume,
    lights: &[GpuLight],
    surfaces: &[VoxelMaterial],
) -> u64 {
    let mut hasher = FixedHasher.build_hasher();
    meshes.hash(&mut hasher);
    for level in &volume.levels {
        let Level {
            center, size, sky, ..
        } = level;
        hash_floats(&mut hasher, &center.to_array());
        hash_floats(&mut hasher, &[*size, level.intensity]);
        for color in [sky.zenith, sky.horizon, sky.ground] {
            hash_floats(&mut hasher, &color.to_f32_array());
        }
    }
    hash_floats(&mut hasher, &[volume.exposure]);
    for viewpoint in &volume.viewpoints {
        hash_floats(&mut hasher, &viewpoint.to_matrix().to_cols_array());
    }
    // Settings are few and change rarely, so their debug text is hashed. A budget's choice is left
    // out: it changes the accuracy of the light, not the light.
    format!("{:?}", volume.own_settings).hash(&mut hasher);
    for light in lights {
        hash_floats(&mut hasher, &light.position.to_array());
        hash_floats(&mut hasher, &light.color.to_array());
        hash_floats(&mut hasher, &light.direction.to_array());
        let others = [
            light.inverse_range_squared,
            light.spot_scale,
            light.spot_offset,
        ];
        hash_floats(&mut hasher, &others);
        light.kind.hash(&mut hasher);
    }
    for surface in surfaces {
        hash_floats(&mut hasher, &surface.albedo.to_array());
        hash_floats(&mut hasher, &surface.emissive.to_array());
        hash_floats(&mut hasher, &[surface.emissive_exposure_weight]);
    }
    hasher.finish()
}

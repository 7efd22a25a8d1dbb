//! Plans what a frame computes: nothing, once nothing has changed for as long as the light needs to settle.

use bevy::{
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::PipelineCache,
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::{
    buffers::{BufferShape, VolumeBuffers},
    fingerprint::{fingerprint, voxel_fingerprint},
    mesh_batches::MeshBatches,
    pipelines::RequiredPipelines,
    scene_buffers::SceneBuffers,
    settling::{Pace, SettlingClock},
    uniforms::{EMPTY_INTERVAL, UniformFrame, VolumeUniforms},
};
use crate::{
    extract::{
        lights::ExtractedLights,
        meshes::ExtractedScene,
        placement::{PlacedLevel, PlacedVolume},
        volume::ExtractedVolume,
    },
    gpu_types::MAX_LEVELS,
    report::{SharedReport, VoxelGiReport, VoxelGiState},
    settings::{Bounces, Solver, VoxelGiVolume, VoxelLight},
};

/// What is computed in this frame, and what decides it.
#[derive(Resource, Default)]
pub(crate) struct FramePlan {
    /// The work of the passes; `None` if nothing is computed.
    pub work: Option<FrameWork>,
    clock: SettlingClock,
    /// Hash of everything that the light depends on, except the settings.
    fingerprint: u64,
    /// Hash of what the voxels depend on, when they were voxelised.
    voxelized: Option<u64>,
    /// The volume's own settings. Those that a budget chooses are left out: they change the accuracy of
    /// the light, not the light.
    settings: VoxelGiVolume,
    /// Placement of the levels in the last frame.
    placement: Vec<PlacedLevel>,
    /// The texture that holds the light.
    texture: Option<AssetId<Image>>,
}

/// The work of the passes in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameWork {
    /// Number of bounces.
    pub bounces: u32,
    /// Number of propagation steps.
    pub iterations: u32,
    /// Whether the scene is voxelised: if not, the voxels are those of the frame before.
    pub voxelizes: bool,
    /// Whether meshes or levels have moved: what cameras saw before is out of date.
    pub has_changed: bool,
    /// By how many of its voxels each level has moved, if any has: reprojected albedo is cleared then.
    pub moves: Option<[IVec4; MAX_LEVELS]>,
}

impl FramePlan {
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
    fn moves(&mut self, volume: &PlacedVolume) -> Option<[IVec4; MAX_LEVELS]> {
        let before = std::mem::replace(&mut self.placement, volume.levels.clone());
        let same = |(old, new): (&PlacedLevel, &PlacedLevel)| {
            (old.owner, old.size) == (new.owner, new.size)
        };
        if before.len() != volume.levels.len() || !before.iter().zip(&volume.levels).all(same) {
            return None;
        }
        let mut moves = [IVec4::ZERO; MAX_LEVELS];
        for ((by, old), new) in moves.iter_mut().zip(&before).zip(&volume.levels) {
            let voxels = (new.center - old.center) / volume.voxel_size(new);
            let whole = (voxels - voxels.round()).abs().max_element() < 1e-3;
            let near = voxels.abs().max_element() < 1e6;
            if whole && near {
                *by = voxels.round().as_ivec3().extend(0);
            }
        }
        (moves != [IVec4::ZERO; MAX_LEVELS]).then_some(moves)
    }
}

/// Rounds in which endlessly reflected light settles, and the mean loses its share from before:
/// (7/8)⁴⁰ = 0.5%.
const SETTLE_MEAN: u32 = 40;

fn pace(settings: &VoxelGiVolume) -> Pace {
    let rounds = match settings.light {
        // Propagation starts over in each frame.
        VoxelLight::GlobalIllumination {
            solver: Solver::Propagate { .. },
            ..
        } => EMPTY_INTERVAL,
        _ => SETTLE_MEAN,
    };
    Pace {
        interval: settings.update_interval,
        rounds,
    }
}

/// Number of bounces and of propagation steps in a frame.
fn bounces_and_iterations(light: VoxelLight) -> (u32, u32) {
    match light {
        VoxelLight::GlobalIllumination { solver, bounces } => {
            let bounces = match bounces {
                Bounces::Count(count) => count,
                Bounces::Endless => 1,
            };
            let iterations = match solver {
                Solver::Propagate { iterations } => iterations,
                Solver::Trace { .. } => 0,
            };
            (bounces, iterations)
        }
        VoxelLight::AmbientOcclusion { .. } => (1, 0),
    }
}

/// Plans the frame, and writes the buffers that all passes share.
pub(crate) fn plan_frame(
    mut commands: Commands,
    mut plan: ResMut<FramePlan>,
    (volume, scene, lights, batches): (
        Res<ExtractedVolume>,
        Res<ExtractedScene>,
        Res<ExtractedLights>,
        Res<MeshBatches>,
    ),
    buffers: Option<Res<VolumeBuffers>>,
    mut uniforms: ResMut<VolumeUniforms>,
    mut required: ResMut<RequiredPipelines>,
    images: Res<RenderAssets<GpuImage>>,
    (device, queue, cache): (Res<RenderDevice>, Res<RenderQueue>, Res<PipelineCache>),
    report: Res<SharedReport>,
) {
    let plan = &mut *plan;
    plan.work = None;
    let pipelines_are_ready = required.take_ready(&cache);
    let Some(volume) = &volume.0 else {
        if buffers.is_some() {
            commands.remove_resource::<VolumeBuffers>();
            commands.remove_resource::<SceneBuffers>();
            *plan = FramePlan::default();
        }
        report.set(VoxelGiReport::default());
        return;
    };
    let Some(texture) = images.get(&volume.texture).filter(|_| pipelines_are_ready) else {
        return;
    };
    let shape = BufferShape::of(volume);
    let is_same = buffers
        .as_ref()
        .is_some_and(|buffers| buffers.shape == shape)
        && plan.texture == Some(volume.texture.id());
    let needed_slots = match &buffers {
        Some(buffers) if is_same => buffers.needed_slots(&device),
        _ => Some(shape.first_slots),
    };
    let is_fresh = needed_slots.is_some();
    if is_fresh {
        *plan = FramePlan {
            texture: Some(volume.texture.id()),
            ..default()
        };
    }
    let pace = pace(&volume.settings);
    let fingerprint = fingerprint(batches.fingerprint, volume, &lights.0, &scene.materials);
    if is_fresh || fingerprint != plan.fingerprint || volume.own_settings != plan.settings {
        plan.fingerprint = fingerprint;
        plan.settings.clone_from(&volume.own_settings);
        let has_moved = plan.has_moved(volume);
        plan.clock.change(pace, has_moved);
    }
    let made = needed_slots.map(|slots| VolumeBuffers::new(&device, shape, slots));
    let Some(buffers) = made.as_ref().or(buffers.as_deref()) else {
        return;
    };
    let pauses = volume.settings.pause_when_settled && plan.clock.has_settled(pace);
    report.set(VoxelGiReport {
        state: if pauses {
            VoxelGiState::Settled
        } else {
            VoxelGiState::Running
        },
        memory: buffers.bytes() + texture_bytes(texture),
        triangles: batches.triangles,
        receiver_patched: volume.patched,
    });
    if pauses {
        return;
    }
    let moves = plan.moves(volume);
    let voxels = voxel_fingerprint(batches.fingerprint, volume);
    let has_changed = plan.voxelized.replace(voxels) != Some(voxels);
    let frame = UniformFrame {
        volume,
        light_count: u32::try_from(lights.0.len()).unwrap_or(u32::MAX),
        frame: plan.clock.frame(),
        blend: plan.clock.blend(pace),
        is_changing: plan.clock.is_changing(pace),
        has_moved: moves.is_some(),
    };
    uniforms.write(frame, &device, &queue);
    plan.clock.advance();
    let (bounces, iterations) = bounces_and_iterations(volume.settings.light);
    plan.work = Some(FrameWork {
        bounces,
        iterations,
        voxelizes: has_changed || shape.marks_visible,
        has_changed,
        moves,
    });
    commands.insert_resource(SceneBuffers::new(
        &scene.materials,
        &lights.0,
        &device,
        &queue,
    ));
    if let Some(made) = made {
        commands.insert_resource(made);
    }
}

fn texture_bytes(texture: &GpuImage) -> u64 {
    let size = texture.texture_descriptor.size;
    8 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
}

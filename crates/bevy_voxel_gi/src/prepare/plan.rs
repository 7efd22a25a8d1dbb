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
    dirty_voxels::DirtyVoxels,
    fingerprint::{fingerprint, voxel_fingerprint},
    materials::MaterialRecords,
    mesh_batches::MeshBatches,
    mesh_group::BATCH_TRIANGLES,
    pipelines::RequiredPipelines,
    scene_buffers::SceneBuffers,
    settling::{Change, Pace, SettlingClock},
    shadow_masks,
    tiles::Tiles,
    uniforms::{EMPTY_INTERVAL, UniformFrame, VolumeUniforms},
};
use crate::{
    extract::{
        lights::ExtractedLights,
        placement::{PlacedLevel, PlacedVolume},
        volume::ExtractedVolume,
    },
    gpu_types::{Changes, MAX_LEVELS},
    passes::draw_sky::SkyCube,
    report::{SharedReport, VoxelGiReport, VoxelGiState},
    settings::{Bounces, Solver, VoxelGiSettings, VoxelLight, Voxelizer},
};

/// What is computed in this frame, and what decides it.
#[derive(Resource, Default)]
pub(crate) struct FramePlan {
    /// The work of the passes; `None` if nothing is computed.
    pub work: Option<FrameWork>,
    clock: SettlingClock,
    /// Hash of everything that the light depends on, except the settings.
    fingerprint: u64,
    /// What the voxels were made of.
    voxelized: Option<Voxelized>,
    /// The app's own settings. Those that a budget chooses are left out: they change the accuracy of
    /// the light, not the light.
    settings: VoxelGiSettings,
    /// Placement of the levels in the last frame.
    placement: Vec<PlacedLevel>,
    /// The texture that holds the light.
    texture: Option<AssetId<Image>>,
}

/// What the voxels depend on.
#[derive(Clone, Copy, PartialEq)]
struct Voxelized {
    /// Hash of everything except colours.
    fingerprint: u64,
    /// Versions of the materials, and of what all have in common.
    materials: u64,
    all_materials: u64,
    voxelizer: Voxelizer,
    has_shadow_masks: bool,
}

/// The work of the passes in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameWork {
    /// Number of bounces.
    pub bounces: u32,
    /// Number of propagation steps.
    pub iterations: u32,
    /// What is voxelised; all other voxels are those of the frame before.
    pub voxelizes: Option<Voxelization>,
    /// Whether meshes or levels have moved: what cameras saw before is out of date.
    pub has_changed: bool,
    /// Whether levels have moved: reprojected albedo is cleared then.
    pub has_moved: bool,
}

/// What is voxelised in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Voxelization {
    Whole,
    /// The voxels that are dirty. Others of these axes have moved in levels that have moved.
    Part {
        moved: BVec3,
    },
}

impl FramePlan {
    /// Whether any level that lights pixels has moved since the last frame.
    fn has_moved(&self, volume: &PlacedVolume) -> bool {
        let before = self.placement.iter().filter(|level| !level.is_outer);
        let centers = volume.lit().iter().map(|level| level.center);
        !before.map(|level| level.center).eq(centers)
    }

    /// By how many of its voxels each level has moved in the world since the last frame; `None` if other levels light
    /// pixels than did. The world has moved, too.
    fn moves(&mut self, volume: &PlacedVolume, world_move: Vec3) -> Option<Moves> {
        let before = std::mem::replace(&mut self.placement, volume.levels.clone());
        let is_same = |old: &PlacedLevel, new: &PlacedLevel| {
            (old.owner, old.size, old.is_outer) == (new.owner, new.size, new.is_outer)
        };
        let count = before.iter().take_while(|level| !level.is_outer).count();
        let are_same = count == volume.lit().len() && { before.iter().zip(volume.lit()) }
            .all(|(old, new)| is_same(old, new));
        if !are_same {
            return None;
        }
        let mut moves = Moves {
            by: default(),
            are_whole: true,
        };
        for (i, (by, new)) in moves.by.iter_mut().zip(&volume.levels).enumerate() {
            let Some(old) = before.get(i).filter(|old| is_same(old, new)) else {
                *by = IVec3::splat(FAR).extend(0);
                continue;
            };
            let (moved, is_whole) =
                voxels_between(old.center + world_move, new.center, volume.voxel_size(new));
            *by = moved.extend(0);
            moves.are_whole &= is_whole;
        }
        Some(moves)
    }
}

/// By how many of its voxels each level has moved.
struct Moves {
    by: [IVec4; MAX_LEVELS],
    /// Whether these are whole ones.
    are_whole: bool,
}

/// So many voxels are outside of any level.
const FAR: i32 = 1_000_000;

/// Parts of a voxel that are rounding.
const ROUNDING: f32 = 1e-3;

/// The number of voxels from one position to another, and whether it is a whole one but for rounding.
fn voxels_between(old: Vec3, new: Vec3, voxel_size: f32) -> (IVec3, bool) {
    let exact = (new - old) / voxel_size;
    let voxels = exact.round();
    if voxels.is_nan() {
        return (IVec3::ZERO, false);
    }
    let far = Vec3::splat(FAR as f32);
    let is_whole = (exact - voxels).abs().max_element() <= ROUNDING;
    (voxels.clamp(-far, far).as_ivec3(), is_whole)
}

/// Rounds in which endlessly reflected light settles, and the mean loses its share from before:
/// (7/8)⁴⁰ = 0.5%.
const SETTLE_MEAN: u32 = 40;

fn pace(settings: &VoxelGiSettings) -> Pace {
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
    (volume, lights, mut batches, mut materials, tiles, sky): (
        Res<ExtractedVolume>,
        Res<ExtractedLights>,
        ResMut<MeshBatches>,
        ResMut<MaterialRecords>,
        Res<Tiles>,
        Res<SkyCube>,
    ),
    (mut buffers, scene_buffers): (Option<ResMut<VolumeBuffers>>, Option<ResMut<SceneBuffers>>),
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
    let shape = BufferShape::beside(volume, buffers.as_deref());
    let former = buffers.as_ref().filter(|former| {
        shape.continues(former.shape) && plan.texture == Some(volume.texture.id())
    });
    let needed_slots = match former {
        Some(former) if former.shape == shape => former.needed_slots(&device),
        Some(former) => Some(former.slots().max(shape.first_slots)),
        None => Some(shape.first_slots),
    };
    let is_fresh = former.is_none();
    if is_fresh {
        *plan = FramePlan {
            texture: Some(volume.texture.id()),
            ..default()
        };
    }
    let pace = pace(&volume.settings);
    let fingerprint = fingerprint(
        batches.fingerprint,
        volume,
        &lights.0,
        &materials,
        sky.version,
    );
    let has_shadow_masks = shadow_masks::are_needed(shape, &batches, &device);
    let voxelized = Voxelized {
        fingerprint: voxel_fingerprint(batches.fingerprint, volume),
        materials: materials.version,
        all_materials: materials.version_of_all,
        voxelizer: volume.settings.voxelizer,
        has_shadow_masks,
    };
    if is_fresh || fingerprint != plan.fingerprint || volume.own_settings != plan.settings {
        plan.fingerprint = fingerprint;
        plan.settings.clone_from(&volume.own_settings);
        let change = if plan.has_moved(volume) {
            Change::Placement
        } else if plan.voxelized == Some(voxelized) {
            Change::Light
        } else {
            Change::Scene
        };
        plan.clock.change(pace, change);
    }
    let mut made = needed_slots.map(|slots| VolumeBuffers::new(&device, shape, slots));
    if let (Some(made), Some(former)) = (&made, former) {
        made.copy_light(former, &device, &queue);
        plan.voxelized = None;
        plan.clock.change(pace, Change::Scene);
    }
    if has_shadow_masks
        && let Some(buffers) = made.as_mut().or(buffers.as_deref_mut())
        && buffers.add_shadow_masks(&device, &queue)
    {
        plan.voxelized = None;
    }
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
        memory: buffers.bytes()
            + texture_bytes(texture)
            + materials.bytes()
            + tiles.bytes()
            + sky.bytes(),
        triangles: batches.triangles,
        voxelized_triangles: u64::from(BATCH_TRIANGLES) * buffers.counts.batches(),
        receiver_patched: volume.patched,
    });
    if pauses {
        return;
    }
    let moves = plan.moves(volume, batches.world_move);
    let before = plan.voxelized.replace(voxelized);
    let has_changed = before.is_none_or(|before| before.fingerprint != voxelized.fingerprint);
    let lacks_slots = buffers.counts.take_lack_of(buffers.slots());
    let are_whole = moves.as_ref().is_some_and(|moves| moves.are_whole);
    let keeps_others = !lacks_slots && !shape.marks_visible && are_whole && {
        let is_same = |before: Voxelized| {
            let Voxelized {
                fingerprint,
                materials,
                ..
            } = voxelized;
            Voxelized {
                fingerprint,
                materials,
                ..before
            } == voxelized
        };
        before.is_some_and(is_same)
    };
    let moves = moves.map(|moves| moves.by).unwrap_or_default();
    let voxelizes = (before != Some(voxelized) || !keeps_others).then(|| {
        let regions = batches.take_changed(&std::mem::take(&mut materials.changed));
        let (resolution, levels) = (volume.settings.resolution, &volume.levels);
        let is_whole = !keeps_others || regions.everything;
        let dirty = if is_whole {
            DirtyVoxels::all(resolution, levels.len())
        } else {
            let mut dirty = DirtyVoxels::none(resolution, levels.len());
            dirty.mark_regions(&regions, levels);
            for (level, by) in (0..).zip(&moves).take(levels.len()) {
                dirty.mark_entered(level, by.truncate());
            }
            dirty
        };
        dirty.write(&buffers.work, VolumeBuffers::COUNTERS_SIZE, &queue);
        uniforms.changes.set(Changes {
            moves,
            is_whole: u32::from(is_whole),
        });
        uniforms.changes.write_buffer(&device, &queue);
        if is_whole {
            return Voxelization::Whole;
        }
        let moves = moves.iter().map(|by| by.truncate().cmpne(IVec3::ZERO));
        Voxelization::Part {
            moved: moves.fold(BVec3::FALSE, |a, b| a | b),
        }
    });
    let has_moved = moves != [IVec4::ZERO; MAX_LEVELS];
    let (bounces, iterations) = bounces_and_iterations(volume.settings.light);
    let frame = UniformFrame {
        volume,
        light_count: u32::try_from(lights.0.len()).unwrap_or(u32::MAX),
        bounces,
        frame: plan.clock.frame(),
        blend: plan.clock.blend(pace),
        is_changing: plan.clock.is_changing(pace),
        emission_unit: materials.emission_unit,
        has_moved,
        voxel_capacity: shape.voxels as u32,
    };
    uniforms.write(frame, &device, &queue);
    plan.clock.advance();
    plan.work = Some(FrameWork {
        bounces,
        iterations,
        voxelizes,
        has_changed,
        has_moved,
    });
    if let Some(mut known) = scene_buffers {
        known.write(&lights.0, &device, &queue);
    } else {
        let mut new = SceneBuffers::default();
        new.write(&lights.0, &device, &queue);
        commands.insert_resource(new);
    }
    if let Some(made) = made {
        commands.insert_resource(made);
    }
}

fn texture_bytes(texture: &GpuImage) -> u64 {
    let size = texture.texture_descriptor.size;
    8 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_volume_moves_by_voxels_far_from_the_origin_too() {
        let voxel_size = 0.3;
        let at = |cell: f32| Vec3::new(cell * voxel_size, 0.0, -cell * voxel_size);
        for start in [0.0_f32, 1e3, 33_333.0, 1e5] {
            let (moved, is_whole) = voxels_between(at(start), at(start + 3.0), voxel_size);
            assert_eq!(moved, IVec3::new(3, 0, -3), "from {start}");
            assert_eq!(is_whole, start < 1e4, "from {start}");
        }
        let (part, is_whole) = voxels_between(Vec3::ZERO, Vec3::splat(0.31), voxel_size);
        assert_eq!((part, is_whole), (IVec3::ONE, false));
        let (far, _) = voxels_between(Vec3::ZERO, Vec3::splat(1e30), voxel_size);
        assert_eq!(far, IVec3::splat(1_000_000));
        let nowhere = voxels_between(Vec3::ZERO, Vec3::NAN, voxel_size);
        assert_eq!(nowhere, (IVec3::ZERO, false));
    }
}

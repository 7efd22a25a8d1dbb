//! Plans what a frame computes: nothing, once nothing has changed for as long as the light needs to settle.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{
    platform::hash::FixedHasher,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::PipelineCache,
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::{
    buffers::{BufferShape, VolumeBuffers, shadow_masks_are_needed},
    level_table::LevelTable,
    materials::MaterialRecords,
    mesh_batches::MeshBatches,
    mesh_group::BATCH_TRIANGLES,
    settling::{Pace, SETTLE, SettlingClock},
    tiles::{LightTiles, Tiles},
    uniforms::{EMPTY_INTERVAL, VolumeUniforms, first_uniform},
    voxelization::{Moves, Voxelization, Voxelized, changes},
};
use crate::{
    extract::{
        lights::ExtractedLights,
        meshes::ExtractedScene,
        place_volume::ExtractedVolume,
        placement::{PlacedLevel, PlacedVolume},
        probe::STORAGE_SCALE,
    },
    gpu_types::{Light, MAX_LEVELS, Volume},
    passes::{draw_sky::SkyCube, kernel::RequiredPipelines},
    report::{SharedReport, VoxelGiReport, VoxelGiState},
    settings::{Bounces, Solver, VoxelGiSettings, VoxelLight, Voxelizer},
};

/// What is computed in this frame, and what decides it.
#[derive(Resource, Default)]
pub(crate) struct FramePlan {
    /// The work of the passes; `None` if nothing is computed.
    pub work: Option<FrameWork>,
    /// Counts the frames with work.
    frame: u32,
    clock: SettlingClock,
    /// Hashes of everything that the light depends on, except the settings.
    fingerprint: Fingerprint,
    /// What the voxels were made of.
    voxelized: Option<Voxelized>,
    /// The app's own settings. Those that a budget chooses are left out: they change the accuracy of
    /// the light, not the light.
    settings: VoxelGiSettings,
    /// Placement of the levels in the last frame.
    placement: Vec<PlacedLevel>,
    /// The texture that holds the light.
    texture: Option<AssetId<Image>>,
    /// The placement as it is in that texture.
    table: LevelTable,
}

/// The work of the passes in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameWork {
    pub bounces: u32,
    pub iterations: u32,
    /// What is voxelised; all other voxels are those of the frame before.
    pub voxelizes: Option<Voxelization>,
    /// Whether meshes or levels have moved: what cameras saw before is out of date.
    pub has_changed: bool,
    /// By how many voxels each level has moved.
    pub moves: [IVec3; MAX_LEVELS],
    /// Whether pixels keep the light that they have.
    pub is_held: bool,
}

impl FrameWork {
    pub(crate) fn has_moved(&self) -> bool {
        self.moves != [IVec3::ZERO; MAX_LEVELS]
    }
}

impl FramePlan {
    /// Whether any level that lights pixels has moved since the last frame.
    fn has_moved(&self, volume: &PlacedVolume) -> bool {
        let before = self.placement.iter().filter(|level| !level.is_outer);
        let centers = volume.lit().iter().map(|level| level.center);
        !before.map(|level| level.center).eq(centers)
    }

    /// The largest part of a level's voxels that were not in it in the last frame.
    fn new_part(&self, volume: &PlacedVolume) -> f32 {
        let levels = self.placement.iter().zip(volume.lit());
        let part = |(old, new): (&PlacedLevel, &PlacedLevel)| {
            let moved = (new.center - old.center).abs() / new.size;
            1.0 - (Vec3::ONE - moved).max(Vec3::ZERO).element_product()
        };
        levels.map(part).fold(0.0, f32::max)
    }
}

fn pace(settings: &VoxelGiSettings) -> Pace {
    Pace {
        interval: settings.update_interval,
        // Propagation starts over in each frame.
        rounds: if settings.light.propagates() {
            EMPTY_INTERVAL
        } else {
            SETTLE
        },
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
    (volume, scene, lights, mut batches, mut materials, tiles, light_tiles, sky): (
        Res<ExtractedVolume>,
        Res<ExtractedScene>,
        Res<ExtractedLights>,
        ResMut<MeshBatches>,
        ResMut<MaterialRecords>,
        Res<Tiles>,
        Res<LightTiles>,
        Res<SkyCube>,
    ),
    mut buffers: Option<ResMut<VolumeBuffers>>,
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
            uniforms.lights = default();
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
        &lights.lights,
        &materials,
        light_tiles.tiles.version,
        sky.version,
    );
    let has_shadow_masks = shadow_masks_are_needed(shape, &batches, &device);
    let voxelized = Voxelized {
        fingerprint: voxel_fingerprint(batches.fingerprint, volume),
        materials: materials.version,
        voxelizer: volume.settings.voxelizer,
        has_shadow_masks,
    };
    if is_fresh
        || fingerprint.scene != plan.fingerprint.scene
        || volume.own_settings != plan.settings
    {
        plan.settings.clone_from(&volume.own_settings);
        let has_moved = plan.has_moved(volume);
        plan.clock.change(pace, has_moved);
    } else if fingerprint.places != plan.fingerprint.places {
        let part = plan.new_part(volume);
        plan.clock.move_volume(pace, part);
    }
    plan.fingerprint = fingerprint;
    let mut made = needed_slots.map(|slots| VolumeBuffers::new(&device, shape, slots));
    if let (Some(made), Some(former)) = (&made, former) {
        made.copy_light(former, &device, &queue);
        plan.voxelized = None;
        plan.clock.change(pace, false);
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
    if volume.patched {
        plan.table.write(volume, texture, &queue);
    }
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
            + light_tiles.tiles.bytes()
            + sky.bytes(),
        triangles: batches.triangles(),
        voxelized_triangles: u64::from(BATCH_TRIANGLES) * buffers.counts.batches(),
        receiver_patched: volume.patched,
    });
    if pauses {
        return;
    }
    let placement = std::mem::replace(&mut plan.placement, volume.levels.clone());
    let moves = Moves::since(&placement, volume, batches.world_move);
    let before = plan.voxelized.replace(voxelized);
    let has_changed = before.is_none_or(|before| before.fingerprint != voxelized.fingerprint);
    let lacks_slots = buffers.counts.take_lack_of(buffers.slots());
    let keeps_others = !lacks_slots
        && !shape.marks_visible
        && moves.as_ref().is_some_and(|moves| moves.are_whole)
        && before.is_some_and(|before| voxelized.continues(before));
    let moved = moves.as_ref().map(|moves| moves.by).unwrap_or_default();
    let voxelizes = (before != Some(voxelized) || !keeps_others).then(|| {
        let regions = batches.take_changed(&std::mem::take(&mut materials.changed), &scene);
        let (dirty, changes) = changes(volume, moves, keeps_others.then_some(regions));
        dirty.write(&buffers.work, VolumeBuffers::COUNTERS_SIZE, &queue);
        uniforms.changes.set(changes);
        uniforms.changes.write_buffer(&device, &queue);
        Voxelization::of(&changes)
    });
    let (bounces, iterations) = bounces_and_iterations(volume.settings.light);
    let work = FrameWork {
        bounces,
        iterations,
        voxelizes,
        has_changed,
        moves: moved.map(|by| by.truncate()),
        is_held: plan.clock.is_held(pace),
    };
    // The words of voxels have 25 bits for it, and 0 is never.
    plan.frame = plan.frame % 0x1ff_ffff + 1;
    let first = Volume {
        frame: plan.frame,
        light_count: u32::try_from(lights.lights.len()).unwrap_or(u32::MAX),
        voxel_capacity: shape.voxels as u32,
        emission_scale: STORAGE_SCALE * materials.emission_unit / volume.exposure,
        ..first_uniform(volume, &work, &plan.clock, pace)
    };
    uniforms.write(first, &lights.lights, &device, &queue);
    plan.work = Some(work);
    plan.clock.advance(pace);
    if let Some(made) = made {
        commands.insert_resource(made);
    }
}

fn texture_bytes(texture: &GpuImage) -> u64 {
    let size = texture.texture_descriptor.size;
    8 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
}

/// Adds floats to a hash by their bits, so that NaN equals itself.
pub(crate) fn hash_floats<const N: usize>(hasher: &mut impl Hasher, floats: &[f32; N]) {
    u32::hash_slice(&floats.map(f32::to_bits), hasher);
}

/// Hash of what the voxels depend on; `meshes` is that of the meshes.
fn voxel_fingerprint(meshes: u64, volume: &PlacedVolume) -> u64 {
    let mut hasher = FixedHasher.build_hasher();
    meshes.hash(&mut hasher);
    for level in &volume.levels {
        hash_floats(&mut hasher, &level.center.to_array());
        hash_floats(&mut hasher, &[level.size]);
    }
    match volume.settings.voxelizer {
        Voxelizer::Conservative => 0,
        Voxelizer::FragmentClipping => 1,
        Voxelizer::GeometryClipping => 2,
        Voxelizer::Stochastic { points } => 3 + u64::from(points),
    }
    .hash(&mut hasher);
    hasher.finish()
}

/// Hashes of what the light depends on, except the settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Fingerprint {
    /// That of the scene, and of the colours that cameras see.
    pub scene: u64,
    /// That of where the levels are.
    pub places: u64,
}

/// `meshes` is the hash of the meshes.
fn fingerprint(
    meshes: u64,
    volume: &PlacedVolume,
    lights: &[Light],
    materials: &MaterialRecords,
    light_tiles_version: u64,
    sky_version: u64,
) -> Fingerprint {
    let mut hasher = FixedHasher.build_hasher();
    let mut places = FixedHasher.build_hasher();
    (meshes, materials.version, light_tiles_version).hash(&mut hasher);
    (sky_version, volume.sky_revision).hash(&mut hasher);
    for level in &volume.levels {
        let PlacedLevel {
            owner: _,
            center,
            // Only pixels notice.
            focus: _,
            step: _,
            size,
            sky,
            intensity,
            sees_map,
            is_outer: _,
        } = level;
        hash_floats(&mut places, &center.to_array());
        hash_floats(&mut hasher, &[*size, *intensity]);
        sees_map.hash(&mut hasher);
        for color in [sky.zenith, sky.horizon, sky.ground] {
            hash_floats(&mut hasher, &color.to_f32_array());
        }
    }
    for viewpoint in &volume.viewpoints {
        hash_floats(&mut hasher, &viewpoint.to_matrix().to_cols_array());
    }
    for light in lights {
        light.words().hash(&mut hasher);
        (light.tile_first, light.tile_size, light.tile_address).hash(&mut hasher);
    }
    if materials.depends_on_exposure {
        hash_floats(&mut hasher, &[volume.exposure]);
    }
    Fingerprint {
        scene: hasher.finish(),
        places: places.finish(),
    }
}

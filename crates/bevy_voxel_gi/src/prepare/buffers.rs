//! The GPU buffers of the volume, and what is read back of them: slots, so that the buffers grow where these are too few,
//! and what was voxelised, for the report.

use std::{
    num::NonZeroU64,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
};

use bevy::{
    ecs::system::SystemParam,
    prelude::*,
    render::{
        render_resource::{
            BindingResource, Buffer, BufferBinding, BufferDescriptor, BufferUsages, CommandEncoder,
            Extent3d, MapMode, Texture, TextureDescriptor, TextureDimension, TextureFormat,
            TextureUsages,
        },
        renderer::{RenderDevice, RenderQueue},
        settings::WgpuLimits,
    },
};

use super::mesh_batches::MeshBatches;
use crate::{
    extract::placement::PlacedVolume,
    settings::{VoxelAlbedo, VoxelGiSettings, Voxelizer},
};

/// The settings that the sizes of the buffers depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BufferShape {
    /// Number of levels that light pixels, and of those around them for which there is room.
    pub lit_levels: usize,
    pub outer_levels: usize,
    pub voxels: u64,
    /// Slots for faces with a surface at first.
    pub first_slots: u64,
    /// Only ambient occlusion is computed, so surfaces have no radiance.
    pub occlusion_only: bool,
    /// Light is propagated from voxel to voxel.
    pub propagates: bool,
    /// Albedo is reprojected from cameras.
    pub reprojects_albedo: bool,
    /// Whether surfaces that cameras see are voxelised, too.
    pub marks_visible: bool,
    /// Pixels test the visibility of voxels, and need the occupancy masks of sub-voxels.
    pub per_pixel: bool,
}

impl BufferShape {
    pub(crate) fn of(volume: &PlacedVolume) -> Self {
        Self::with_levels(volume, volume.levels.len() - volume.lit().len())
    }

    /// The same with as much room around the volumes as there was: levels come and go there as cameras move.
    pub(super) fn beside(volume: &PlacedVolume, known: Option<&VolumeBuffers>) -> Self {
        let new = Self::of(volume);
        let known = known.map(|buffers| buffers.shape);
        let known = known.filter(|known| known.lit_levels == new.lit_levels);
        let room = known.map_or(0, |known| known.outer_levels);
        Self::with_levels(volume, new.outer_levels.max(room))
    }

    fn with_levels(volume: &PlacedVolume, outer_levels: usize) -> Self {
        let r = u64::from(volume.settings.resolution);
        let lit_levels = volume.lit().len();
        let levels = (lit_levels + outer_levels) as u64;
        let occlusion_only = volume.settings.light.is_occlusion();
        let reprojects_albedo =
            volume.settings.albedo == VoxelAlbedo::Reprojected && !occlusion_only;
        Self {
            lit_levels,
            outer_levels,
            voxels: r * r * r * levels,
            first_slots: first_slots(r, levels),
            propagates: volume.settings.light.propagates(),
            occlusion_only,
            per_pixel: volume.is_per_pixel(),
            reprojects_albedo,
            marks_visible: reprojects_albedo
                && matches!(volume.settings.voxelizer, Voxelizer::Stochastic { .. }),
        }
    }

    /// Whether buffers of this shape have the same voxels as those of another one, with more or less room around the
    /// volumes.
    pub(super) fn continues(self, former: Self) -> bool {
        let Self {
            outer_levels,
            voxels,
            first_slots,
            ..
        } = self;
        let same = Self {
            outer_levels,
            voxels,
            first_slots,
            ..former
        };
        self == same
    }

    /// Size in bytes of the words that have the slots of voxels.
    fn slot_word_bytes(self) -> u64 {
        4 * self.voxels
    }

    /// Size of the occupancy masks in bytes, with those of the meshes that cast shadows or without.
    pub(super) fn mask_bytes(self, with_shadow_masks: bool) -> u64 {
        8 * self.voxels * (1 + u64::from(with_shadow_masks))
    }

    /// Whether neighbouring surfaces share their light. Occlusion changes within its radius, which may be a few voxels:
    /// sharing would blur it.
    pub(crate) fn shares_light(self) -> bool {
        !self.occlusion_only && !self.propagates
    }
}

/// Number of slots for faces with a surface at first, a face of a level's cube being 1 for each of its voxels.
/// Surfaces are a shell: a closed room whose walls have two sides takes 12, one that is rotated up to 36.
const FIRST_SLOTS: u64 = 24;
/// The same in each further level.
const FURTHER_SLOTS: u64 = 6;

fn first_slots(resolution: u64, levels: u64) -> u64 {
    let faces = FIRST_SLOTS + FURTHER_SLOTS * levels.saturating_sub(1);
    most_slots(resolution.pow(3) * levels).min(faces * resolution.pow(2))
}

/// Slots for all faces, and the one that all faces without a surface read. Their numbers have 25 bits.
fn most_slots(voxels: u64) -> u64 {
    (6 * voxels + 1).min(1 << 25)
}

/// Size of the largest storage buffer that a device binds.
pub(crate) fn most_bytes(limits: &WgpuLimits) -> u64 {
    let bound = limits.max_storage_buffer_binding_size;
    bound.min(limits.max_buffer_size)
}

/// What was counted on the GPU, as far as it has been read back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counts(Arc<CountsInner>);

#[derive(Debug, Default)]
struct CountsInner {
    /// The most slots that faces needed where everything was voxelised.
    slots_of_whole: AtomicU32,
    /// The same where parts were since then: slots that have become free are not used in rows of other lengths.
    slots_of_parts: AtomicU32,
    /// Number of batches of triangles that were voxelised last.
    batches: AtomicU32,
}

impl Counts {
    fn raise_slots(&self, faces: u32, is_whole: bool) {
        let slots = if is_whole {
            &self.0.slots_of_whole
        } else {
            &self.0.slots_of_parts
        };
        // One more is what faces without a surface read.
        slots.fetch_max(faces.saturating_add(1), Ordering::Relaxed);
    }

    fn set_batches(&self, batches: u32) {
        self.0.batches.store(batches, Ordering::Relaxed);
    }

    pub(super) fn batches(&self) -> u64 {
        self.0.batches.load(Ordering::Relaxed).into()
    }

    fn slots_of_whole(&self) -> u64 {
        self.0.slots_of_whole.load(Ordering::Relaxed).into()
    }

    /// Whether so many slots are hardly enough for the parts that were voxelised. Everything is to be voxelised then,
    /// which uses as few as possible.
    pub(super) fn take_lack_of(&self, slots: u64) -> bool {
        let lacks = u64::from(self.0.slots_of_parts.load(Ordering::Relaxed)) > slots - slots / 8;
        if lacks {
            self.0.slots_of_parts.store(0, Ordering::Relaxed);
        }
        lacks
    }
}

/// A copy of the counts of this frame that is not read yet, and whether everything was voxelised.
#[derive(Resource, Default)]
pub(crate) struct CountsCopy(Option<(Buffer, bool)>);

impl CountsCopy {
    /// Copies the number of slots, then other counts from their places in other buffers.
    pub(crate) fn record<'a>(
        &mut self,
        encoder: &mut CommandEncoder,
        buffers: &VolumeBuffers,
        batches: impl ExactSizeIterator<Item = (&'a Buffer, u64)>,
        is_whole: bool,
        device: &RenderDevice,
    ) {
        let copy = device.create_buffer(&BufferDescriptor {
            label: Some("voxel_gi_counts"),
            size: 4 + 4 * batches.len() as u64,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(&buffers.slot_lists, 0, &copy, 0, 4);
        for (i, (buffer, offset)) in (1..).zip(batches) {
            encoder.copy_buffer_to_buffer(buffer, offset, &copy, 4 * i, 4);
        }
        self.0 = Some((copy, is_whole));
    }
}

/// Asks for the copy of this frame; it arrives some frames later.
pub(crate) fn read_back(mut copy: ResMut<CountsCopy>, buffers: Option<Res<VolumeBuffers>>) {
    let (Some((copy, is_whole)), Some(buffers)) = (copy.0.take(), buffers) else {
        return;
    };
    let counts = buffers.counts.clone();
    copy.clone()
        .slice(..)
        .map_async(MapMode::Read, move |result| {
            if result.is_ok()
                && let Ok(bytes) = copy.slice(..).get_mapped_range()
                && let (words, []) = bytes.as_chunks()
                && let [slots, batches @ ..] = words
            {
                counts.raise_slots(u32::from_le_bytes(*slots), is_whole);
                let batches = batches.iter().map(|batches| u32::from_le_bytes(*batches));
                counts.set_batches(batches.sum());
            }
        });
}

/// Size in bytes of the largest buffer that settings need at first.
pub(crate) fn largest_buffer(settings: &VoxelGiSettings, resolution: u32, levels: u64) -> u64 {
    let resolution = u64::from(resolution);
    let voxels = resolution.pow(3) * levels;
    let slots = first_slots(resolution, levels);
    if settings.light.propagates() {
        // The light that has arrived through each face.
        return 96 * voxels;
    }
    let of_cameras = match (settings.albedo, settings.voxelizer) {
        _ if settings.light.is_occlusion() => 0,
        (VoxelAlbedo::Reprojected, Voxelizer::Stochastic { .. }) => 32 * voxels,
        (VoxelAlbedo::Reprojected, _) => 24 * voxels,
        _ => 0,
    };
    // The occupancy, the work, and the sums of the slots.
    (8 * voxels)
        .max(VolumeBuffers::COUNTERS_SIZE + 4 * (slots + voxels))
        .max(32 * slots.next_multiple_of(32))
        .max(of_cameras)
}

pub(super) const STORAGE: BufferUsages = BufferUsages::STORAGE
    .union(BufferUsages::COPY_DST)
    .union(BufferUsages::COPY_SRC);

/// Creates a buffer, which is not empty.
pub(crate) fn buffer(
    device: &RenderDevice,
    label: &'static str,
    size: u64,
    usage: BufferUsages,
) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: Some(label),
        size: size.max(16),
        usage,
        mapped_at_creation: false,
    })
}

/// A part of a buffer, up to its end if no size is given.
pub(super) fn part_of(
    buffer: &Buffer,
    offset: u64,
    size: Option<NonZeroU64>,
) -> BindingResource<'_> {
    BindingResource::Buffer(BufferBinding {
        buffer,
        offset,
        size,
    })
}

/// Creates a texture of two dimensions without further mip levels.
pub(crate) fn texture(
    device: &RenderDevice,
    label: &'static str,
    [width, height, depth_or_array_layers]: [u32; 3],
    format: TextureFormat,
    usage: TextureUsages,
) -> Texture {
    device.create_texture(&TextureDescriptor {
        label: Some(label),
        size: Extent3d {
            width,
            height,
            depth_or_array_layers,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn voxels(device: &RenderDevice, shape: BufferShape, with_shadow_masks: bool) -> Buffer {
    let size = shape.slot_word_bytes() + shape.mask_bytes(with_shadow_masks);
    buffer(device, "voxel_gi_voxels", size, STORAGE)
}

/// The buffers of the volume.
#[derive(Resource)]
pub(crate) struct VolumeBuffers {
    pub shape: BufferShape,
    /// A word per voxel: which of its faces have a surface, and their slots in the buffers below. Then 64 bits per
    /// voxel: the occupancy of its sub-voxels. Once a mesh casts no shadow, the occupancy by all that do follows; see
    /// [`ShadowMasks`].
    pub voxels: Buffer,
    /// A word per slot: the packed surface.
    pub packed_surfaces: Buffer,
    /// Four words per slot: irradiance in this round, with the distance of the surface from the voxel's centre,
    /// and the mean over rounds with its weight, as 16-bit floats.
    pub irradiance: Buffer,
    /// Eight words per slot: four of the irradiance as it was, two of the radiance that leaves the surface, as 16-bit
    /// floats, and two of its albedo and emission. While the scene is voxelised, its `sums` in `bindings.wesl` are there.
    pub sums: Buffer,
    /// The number of slots that were ever used, and the first free slots; see `bindings.wesl`.
    pub slot_lists: Buffer,
    pub counts: Counts,
    /// Six times four words per voxel: the propagated light that has arrived through each face, as 32-bit floats. A
    /// stub without propagation.
    pub arrived: Buffer,
    /// Sixteen words per voxel each: propagated light before and after a step. Stubs without propagation.
    pub intensity: [Buffer; 2],
    /// Six words per voxel: reprojected albedo of each face. A stub without reprojection.
    pub reprojected_albedo: Buffer,
    /// Eight words per voxel: the surfaces that cameras see there; see `mark_visible.wesl`. Its size is minimal where
    /// these are not voxelised.
    pub visible: Buffer,
    /// The number of surfaces and of empty voxels, then the indirect dispatch arguments over the first two;
    /// then the compacted work, surfaces first, then empty voxels: voxel index times 8 plus face. While the scene is
    /// voxelised, it has a bit per voxel in place of the former, whether it is voxelised anew, and the slots of voxels
    /// as they were in place of the latter.
    pub work: Buffer,
    /// The copy of these arguments that indirect dispatches read.
    pub indirect_args: Buffer,
}

impl VolumeBuffers {
    pub(crate) const COUNTERS_SIZE: u64 = Self::ARGS_OFFSET + Self::ARGS_SIZE;
    /// Byte offset of the indirect dispatch arguments in `work`.
    pub(crate) const ARGS_OFFSET: u64 = 16;
    pub(crate) const ARGS_SIZE: u64 = 48;
    /// Byte offsets of the indirect dispatch arguments: a workgroup for each surface, for each empty voxel,
    /// and for 64 surfaces.
    pub(crate) const SURFACE_ARGS: u64 = 0;
    pub(crate) const EMPTY_VOXEL_ARGS: u64 = 16;
    pub(crate) const SURFACE_THREAD_ARGS: u64 = 32;

    /// `slots` is the number of slots for faces with a surface.
    pub(crate) fn new(device: &RenderDevice, shape: BufferShape, slots: u64) -> Self {
        // The parts of `sums` can be bound if they start at multiples of 256 bytes.
        let slots = slots.next_multiple_of(32);
        let buffer = |label, size, usage| buffer(device, label, size, usage);
        let storage = STORAGE;
        let per_voxel = |bytes: u64| bytes * shape.voxels;
        let per_slot = |bytes: u64| bytes * slots;
        let when = |is_used: bool, bytes: u64| if is_used { bytes } else { 0 };
        let propagated = |bytes: u64| when(shape.propagates, per_voxel(bytes));
        Self {
            shape,
            voxels: voxels(device, shape, false),
            packed_surfaces: buffer("voxel_gi_packed_surfaces", per_slot(4), storage),
            irradiance: buffer("voxel_gi_irradiance", per_slot(16), storage),
            sums: buffer("voxel_gi_sums", per_slot(32), storage),
            slot_lists: buffer("voxel_gi_slot_lists", 28, storage),
            counts: Counts::default(),
            intensity: ["voxel_gi_intensity_a", "voxel_gi_intensity_b"]
                .map(|label| buffer(label, propagated(64).max(64), storage)),
            arrived: buffer("voxel_gi_arrived", propagated(96), storage),
            reprojected_albedo: buffer(
                "voxel_gi_reprojected_albedo",
                when(shape.reprojects_albedo, per_voxel(24)),
                storage,
            ),
            visible: buffer(
                "voxel_gi_visible",
                when(shape.marks_visible, per_voxel(32)),
                storage,
            ),
            work: buffer(
                "voxel_gi_work",
                Self::COUNTERS_SIZE + per_slot(4) + per_voxel(4),
                storage,
            ),
            indirect_args: buffer(
                "voxel_gi_indirect_args",
                Self::ARGS_SIZE,
                BufferUsages::INDIRECT | BufferUsages::COPY_DST,
            ),
        }
    }

    /// Takes over the light of other buffers of the same voxels, from which the passes continue.
    pub(super) fn copy_light(&self, former: &Self, device: &RenderDevice, queue: &RenderQueue) {
        let mut encoder = device.create_command_encoder(&default());
        let bytes = |buffers: &Self| {
            let slots = buffers.shape.slot_word_bytes();
            [slots, buffers.irradiance.size()]
        };
        let [slots, light] = bytes(former);
        let [most_slots, most_light] = bytes(self);
        let slots = slots.min(most_slots);
        encoder.copy_buffer_to_buffer(&former.voxels, 0, &self.voxels, 0, slots);
        let light = light.min(most_light);
        encoder.copy_buffer_to_buffer(&former.irradiance, 0, &self.irradiance, 0, light);
        queue.submit([encoder.finish()]);
    }

    /// Makes room for the masks of meshes that cast shadows, and returns whether there was none: the scene has to be
    /// voxelised.
    pub(crate) fn add_shadow_masks(&mut self, device: &RenderDevice, queue: &RenderQueue) -> bool {
        let slots = self.shape.slot_word_bytes();
        let is_new = !self.has_shadow_masks();
        if is_new {
            let former = std::mem::replace(&mut self.voxels, voxels(device, self.shape, true));
            let mut encoder = device.create_command_encoder(&default());
            encoder.copy_buffer_to_buffer(&former, 0, &self.voxels, 0, slots);
            queue.submit([encoder.finish()]);
        }
        is_new
    }

    pub(crate) fn has_shadow_masks(&self) -> bool {
        self.voxels.size() >= self.shape.slot_word_bytes() + self.shape.mask_bytes(true)
    }

    /// The slots of voxels.
    pub(crate) fn face_slots(&self) -> BindingResource<'_> {
        let bytes = self.shape.slot_word_bytes();
        part_of(&self.voxels, 0, NonZeroU64::new(bytes))
    }

    /// The occupancy masks.
    pub(crate) fn masks(&self) -> BindingResource<'_> {
        part_of(&self.voxels, self.shape.slot_word_bytes(), None)
    }

    /// So many words of each slot in `sums`, after these.
    fn part_of_sums(&self, before: u64, words: u64) -> BindingResource<'_> {
        let words_of = |words: u64| 4 * words * self.slots();
        let size = NonZeroU64::new(words_of(words));
        part_of(&self.sums, words_of(before), size)
    }

    /// Radiance that leaves the surface of each slot.
    pub(crate) fn radiance(&self) -> BindingResource<'_> {
        self.part_of_sums(4, 2)
    }

    /// Albedo and emission of each slot.
    pub(crate) fn colors(&self) -> BindingResource<'_> {
        self.part_of_sums(6, 2)
    }

    /// Where in `work` the slots of voxels are as they were, and the size of them in bytes.
    pub(crate) fn former_slot_words(&self) -> (u64, u64) {
        let offset = Self::COUNTERS_SIZE + self.packed_surfaces.size();
        (offset, self.shape.slot_word_bytes())
    }

    /// Number of slots that the buffers have.
    pub(super) fn slots(&self) -> u64 {
        self.irradiance.size() / 16
    }

    /// The number of slots that new buffers need if these have too few for the surfaces: half as many again, as far
    /// as the device binds buffers of that size.
    pub(crate) fn needed_slots(&self, device: &RenderDevice) -> Option<u64> {
        let demand = self.counts.slots_of_whole();
        if demand <= self.slots() {
            return None;
        }
        let limit = most_bytes(&device.limits());
        let most = most_slots(self.shape.voxels).min(limit / 32 / 32 * 32);
        let slots = (demand + demand / 2).min(most);
        if slots < demand {
            warn_once!(
                "voxel GI: the surfaces need {} MiB in a storage buffer, and this device binds {} MiB at most, so \
                 some have no light. Lower `resolution` or `cascades`",
                (32 * demand) >> 20,
                limit >> 20,
            );
        }
        (slots > self.slots()).then_some(slots)
    }

    /// Total size of the buffers in bytes, as allocated.
    pub(crate) fn bytes(&self) -> u64 {
        [
            &self.voxels,
            &self.packed_surfaces,
            &self.irradiance,
            &self.sums,
            &self.slot_lists,
            &self.arrived,
            &self.intensity[0],
            &self.intensity[1],
            &self.reprojected_albedo,
            &self.visible,
            &self.work,
            &self.indirect_args,
        ]
        .map(|buffer| buffer.size())
        .iter()
        .sum()
    }
}

/// Decides whether rays of direct light need occupancy masks of their own in a frame, as some meshes cast no shadow.
#[derive(SystemParam)]
pub(crate) struct ShadowMasks<'w> {
    batches: Res<'w, MeshBatches>,
    device: Res<'w, RenderDevice>,
}

impl ShadowMasks<'_> {
    /// The shader def of the passes that write or read these masks, where they are needed.
    pub(crate) fn defs(&self, shape: BufferShape) -> Option<&'static str> {
        shadow_masks_are_needed(shape, &self.batches, &self.device).then_some("SHADOW_MASKS")
    }
}

/// Whether the masks of meshes that cast shadows are behind those of all meshes.
pub(super) fn shadow_masks_are_needed(
    shape: BufferShape,
    batches: &MeshBatches,
    device: &RenderDevice,
) -> bool {
    if shape.occlusion_only || !batches.have_mesh_without_shadow() {
        return false;
    }
    let most = most_bytes(&device.limits());
    let fits = shape.mask_bytes(true) <= most;
    if !fits {
        warn_once!(
            "voxel GI: `NotShadowCaster` takes a storage buffer of {} MiB, and this device binds {} MiB at most, so \
             such meshes cast shadows. Lower `resolution` or `cascades`",
            shape.mask_bytes(true) >> 20,
            most >> 20,
        );
    }
    fits
}

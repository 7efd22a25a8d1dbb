//! Meshes that share their buffers, and their lists on the GPU.

use std::{num::NonZeroU64, ops::Range};

use bevy::{
    math::{Vec3, Vec3A},
    platform::collections::HashMap,
    render::{
        render_resource::{
            BindingResource, Buffer, BufferBinding, BufferDescriptor, BufferUsages,
            CommandEncoderDescriptor, ShaderSize, ShaderType,
            encase::internal::{WriteInto, Writer},
        },
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::dirty_voxels::Bounds;
use crate::gpu_types::{MeshBatch, MeshInstance};

/// Number of triangles in a batch.
pub(super) const BATCH_TRIANGLES: u32 = 64;

/// A bit for each level that a mesh may reach into.
pub(super) type LevelMask = u32;

/// Meshes that share their buffers.
pub(crate) struct MeshGroup {
    /// Vertices, indices and morph targets, if the meshes have them.
    pub buffers: [Option<Buffer>; 3],
    instances: List<MeshInstance>,
    batches: List<MeshBatch>,
    /// The first batch of each instance.
    first_batches: Vec<usize>,
    /// Places without a mesh, with so many batches.
    free: HashMap<usize, Vec<usize>>,
    /// Number of their batches.
    idle_batches: usize,
    /// Places without a mesh and without batches.
    vacant: Vec<usize>,
    /// Number of meshes.
    count: usize,
    /// Number of batches of meshes, in all levels that these may reach into.
    item_count: usize,
    /// What is voxelised in a frame; see `TriangleItems` in `gpu_types.wesl`.
    items: Option<Buffer>,
}

/// The lists of a group on the GPU.
pub(crate) struct UploadedGroup<'a> {
    pub instances: BindingResource<'a>,
    pub batches: BindingResource<'a>,
    pub batch_count: u32,
    pub items: Buffer,
}

/// Number of batches of a mesh.
fn batch_count(triangles: u32) -> usize {
    triangles.div_ceil(BATCH_TRIANGLES) as usize
}

/// Number of batches of a mesh in all levels that it may reach into.
fn item_count(instance: &MeshInstance) -> usize {
    batch_count(instance.triangle_count) * instance.levels.count_ones() as usize
}

impl MeshGroup {
    /// So few batches without a mesh are left alone.
    const FEW_BATCHES: usize = 64;
    /// Bytes before the items in their buffer: indirect dispatch arguments, and the number of items.
    pub(crate) const ITEMS_HEADER: u64 = 16;

    pub(super) fn new(buffers: [Option<Buffer>; 3]) -> Self {
        Self {
            buffers,
            instances: List::new("voxel_gi_mesh_instances"),
            batches: List::new("voxel_gi_mesh_batches"),
            first_batches: Vec::new(),
            free: HashMap::default(),
            idle_batches: 0,
            vacant: Vec::new(),
            count: 0,
            item_count: 0,
            items: None,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub(super) fn instance(&self, place: usize) -> &MeshInstance {
        &self.instances.items[place]
    }

    /// Adds a mesh, and returns the place of its instance. `bounds` are those in the world of a mesh that is deformed;
    /// those of others are found on the GPU.
    pub(super) fn add(&mut self, instance: MeshInstance, bounds: Option<Bounds>) -> usize {
        self.count += 1;
        self.item_count += item_count(&instance);
        let batches = batch_count(instance.triangle_count);
        let free = self.free.get_mut(&batches);
        if let Some(place) = free.and_then(Vec::pop) {
            self.idle_batches -= batches;
            self.instances.set(place, instance);
            self.set_bounds(place, bounds);
            return place;
        }
        let place = self.vacant.pop().unwrap_or(self.first_batches.len());
        if place == self.first_batches.len() {
            self.first_batches.push(0);
            self.instances.push(instance);
        } else {
            self.instances.set(place, instance);
        }
        self.first_batches[place] = self.batches.items.len();
        for first_triangle in (0..instance.triangle_count).step_by(BATCH_TRIANGLES as usize) {
            self.batches.push(batch(place, first_triangle, bounds));
        }
        place
    }

    /// Gives all batches of a mesh these bounds.
    fn set_bounds(&mut self, place: usize, bounds: Option<Bounds>) {
        let first = self.first_batches[place];
        let triangles = self.instances.items[place].triangle_count;
        let first_triangles = (0..triangles).step_by(BATCH_TRIANGLES as usize);
        for (at, first_triangle) in (first..).zip(first_triangles) {
            self.batches.set(at, batch(place, first_triangle, bounds));
        }
    }

    /// Replaces an instance if it has as many triangles, and returns the former one. `is_same_mesh` says whether these
    /// are where they were in the mesh's own space.
    pub(super) fn replace(
        &mut self,
        place: usize,
        instance: MeshInstance,
        is_same_mesh: bool,
    ) -> Option<MeshInstance> {
        let former = self.instances.items[place];
        if former.triangle_count != instance.triangle_count {
            return None;
        }
        self.item_count += item_count(&instance);
        self.item_count -= item_count(&former);
        self.instances.set(place, instance);
        if !is_same_mesh {
            self.set_bounds(place, None);
        }
        Some(former)
    }

    /// Removes a mesh: its batches have no triangles until another one takes its place, or until they are more than
    /// those of meshes.
    pub(super) fn remove(&mut self, place: usize) -> MeshInstance {
        let removed = self.instances.items[place];
        let without_triangles = MeshInstance {
            triangle_count: 0,
            ..removed
        };
        self.instances.set(place, without_triangles);
        let batches = batch_count(removed.triangle_count);
        self.free.entry(batches).or_default().push(place);
        self.idle_batches += batches;
        self.item_count -= item_count(&removed);
        self.count -= 1;
        let used = self.batches.items.len() - self.idle_batches;
        if self.idle_batches > used + Self::FEW_BATCHES {
            self.compact();
        }
        removed
    }

    /// Removes the batches without a mesh.
    fn compact(&mut self) {
        let former = std::mem::take(&mut self.batches.items);
        self.batches.clear();
        let has_mesh = |batch: &MeshBatch| {
            let instance = self.instances.items[batch.instance as usize];
            batch.first_triangle < instance.triangle_count
        };
        for batch in former.into_iter().filter(has_mesh) {
            if batch.first_triangle == 0 {
                self.first_batches[batch.instance as usize] = self.batches.items.len();
            }
            self.batches.push(batch);
        }
        self.vacant
            .extend(self.free.drain().flat_map(|(_, places)| places));
        self.idle_batches = 0;
    }

    /// Writes what has changed; `None` if there is nothing to voxelise.
    pub(crate) fn upload(
        &mut self,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<UploadedGroup<'_>> {
        let batch_count = u32::try_from(self.batches.items.len()).unwrap_or(u32::MAX);
        let needed = Self::ITEMS_HEADER + 8 * self.item_count.max(1) as u64;
        let items = self.items.take().filter(|items| items.size() >= needed);
        let items = items.unwrap_or_else(|| {
            device.create_buffer(&BufferDescriptor {
                label: Some("voxel_gi_triangle_items"),
                size: needed,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        self.items = Some(items.clone());
        Some(UploadedGroup {
            instances: self.instances.upload(device, queue)?,
            batches: self.batches.upload(device, queue)?,
            batch_count,
            items,
        })
    }
}

/// A batch whose bounds are found on the GPU, if they are not given.
fn batch(place: usize, first_triangle: u32, bounds: Option<Bounds>) -> MeshBatch {
    let unknown = (Vec3::splat(f32::MAX), Vec3::splat(f32::MIN));
    let (low, high) = bounds.map_or(unknown, |(center, half_size)| {
        let most = Vec3A::splat(f32::MAX);
        let within = |corner: Vec3A| Vec3::from(corner.clamp(-most, most));
        (within(center - half_size), within(center + half_size))
    });
    MeshBatch {
        low,
        instance: u32::try_from(place).unwrap_or(u32::MAX),
        high,
        first_triangle,
    }
}

/// Items, and their copy on the GPU.
struct List<T> {
    label: &'static str,
    items: Vec<T>,
    /// The copy, which may have room for more.
    buffer: Option<Buffer>,
    /// Places of the items that have changed since they were copied.
    changed: Vec<usize>,
}

impl<T: ShaderType + ShaderSize + WriteInto> List<T> {
    fn new(label: &'static str) -> Self {
        Self {
            label,
            items: Vec::new(),
            buffer: None,
            changed: Vec::new(),
        }
    }

    fn push(&mut self, item: T) {
        self.changed.push(self.items.len());
        self.items.push(item);
    }

    fn clear(&mut self) {
        self.items.clear();
        self.changed.clear();
    }

    fn set(&mut self, place: usize, item: T) {
        self.items[place] = item;
        self.changed.push(place);
        // Frames may pass until they are copied.
        if self.changed.len() > 2 * self.items.len() {
            self.changed.sort_unstable();
            self.changed.dedup();
        }
    }

    /// Copies what has changed, and returns the copy without its room; `None` if there are no items.
    fn upload(
        &mut self,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<BindingResource<'_>> {
        let size = T::SHADER_SIZE.get();
        let needed = size * self.items.len() as u64;
        let bound = NonZeroU64::new(needed)?;
        if self
            .buffer
            .as_ref()
            .is_none_or(|buffer| buffer.size() < needed)
        {
            // Room for half as many more, where this one was too small.
            let room = if self.buffer.is_some() {
                needed / size / 2 * size
            } else {
                0
            };
            self.changed = (0..self.items.len()).collect();
            self.buffer = Some(device.create_buffer(&BufferDescriptor {
                label: Some(self.label),
                size: needed + room,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        let buffer = self.buffer.as_ref()?;
        self.changed.sort_unstable();
        let runs: Vec<_> = runs(&self.changed).collect();
        if runs.len() <= MOST_WRITES {
            for places in runs {
                let offset = places.start as u64 * size;
                queue.write_buffer(buffer, offset, &bytes([&self.items[places]]));
            }
        } else {
            let all = bytes(runs.iter().map(|places| &self.items[places.clone()]));
            // Not with contents: where a device is lost, that would end the app.
            let staging = device.create_buffer(&BufferDescriptor {
                label: Some(self.label),
                size: all.len() as u64,
                usage: BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&staging, 0, &all);
            let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
            let mut from = 0;
            for places in runs {
                let (offset, bytes) = (places.start as u64 * size, places.len() as u64 * size);
                encoder.copy_buffer_to_buffer(&staging, from, buffer, offset, bytes);
                from += bytes;
            }
            queue.submit([encoder.finish()]);
        }
        self.changed.clear();
        Some(BindingResource::Buffer(BufferBinding {
            buffer,
            offset: 0,
            size: Some(bound),
        }))
    }
}

/// More writes than these are made at once: each takes a buffer of its own until the GPU has copied it.
const MOST_WRITES: usize = 16;

/// The most unchanged items between two changed ones that are written with them: each write has a price of its own.
const GAP: usize = 16;

/// Ranges that contain all of the sorted places.
fn runs(places: &[usize]) -> impl Iterator<Item = Range<usize>> {
    let chunks = places.chunk_by(|a, b| b - a <= GAP);
    chunks.map(|chunk| chunk[0]..chunk[chunk.len() - 1] + 1)
}

/// Lists one after the other.
fn bytes<'a, T: ShaderType + ShaderSize + WriteInto + 'a>(
    lists: impl IntoIterator<Item = &'a [T]>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    for list in lists {
        let at = bytes.len();
        let mut writer = Writer::new(list, &mut bytes, at).expect("a vector grows");
        list.write_into(&mut writer);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_contain_all_places_and_no_large_gaps() {
        let found: Vec<_> = runs(&[0, 1, 5, 5 + GAP, 6 + 2 * GAP, 100]).collect();
        assert_eq!(found, [0..6 + GAP, 6 + 2 * GAP..7 + 2 * GAP, 100..101]);
        assert_eq!(runs(&[]).count(), 0);
    }

    fn mesh(triangle_count: u32) -> MeshInstance {
        MeshInstance {
            triangle_count,
            levels: 0b101,
            ..MeshInstance::default()
        }
    }

    impl MeshGroup {
        /// The batches of each mesh are there once, where its instance says.
        fn check(&self, places: &[usize]) {
            for &place in places {
                let triangles = self.instances.items[place].triangle_count;
                let own = { self.batches.items.iter() }.filter(|batch| {
                    batch.instance as usize == place && batch.first_triangle < triangles
                });
                assert_eq!(own.count(), batch_count(triangles), "mesh {place}");
                for number in 0..batch_count(triangles) {
                    let batch = &self.batches.items[self.first_batches[place] + number];
                    let expected = (place as u32, 64 * number as u32);
                    assert_eq!((batch.instance, batch.first_triangle), expected);
                }
            }
            let used: usize = places
                .iter()
                .map(|&place| item_count(&self.instances.items[place]))
                .sum();
            assert_eq!(self.item_count, used);
        }
    }

    #[test]
    fn meshes_that_come_and_go_take_the_places_of_their_like() {
        let mut group = MeshGroup::new([const { None }; 3]);
        let places: Vec<_> = (0..10).map(|_| group.add(mesh(100), None)).collect();
        assert_eq!(group.batches.items.len(), 10 * 2);
        for _ in 0..50 {
            assert_eq!(group.remove(places[3]).triangle_count, 100);
            assert_eq!(group.instances.items[places[3]].triangle_count, 0);
            assert_eq!(group.add(mesh(100), None), places[3]);
        }
        assert_eq!(group.batches.items.len(), 10 * 2);
        group.check(&places);
        group.remove(places[0]);
        assert_eq!(group.add(mesh(64), None), 10, "other triangles");
        assert!(group.replace(1, mesh(64), true).is_none());
        assert!(group.replace(1, mesh(100), true).is_some());
        for place in 1..10 {
            group.remove(place);
        }
        assert!(!group.is_empty());
        group.remove(10);
        assert!(group.is_empty());
        assert_eq!(group.item_count, 0);
    }

    #[test]
    fn bounds_are_kept_as_long_as_the_mesh_is_the_same() {
        let mut group = MeshGroup::new([const { None }; 3]);
        let given = (Vec3A::ONE, Vec3A::splat(0.5));
        let place = group.add(mesh(100), Some(given));
        let low = |group: &MeshGroup| [0, 1].map(|i| group.batches.items[i].low.x);
        assert_eq!(low(&group), [0.5; 2]);
        group.replace(place, mesh(100), true);
        assert_eq!(low(&group), [0.5; 2]);
        group.replace(place, mesh(100), false);
        assert_eq!(low(&group), [f32::MAX; 2]);
        group.remove(place);
        group.add(mesh(120), Some((Vec3A::ZERO, Vec3A::INFINITY)));
        assert_eq!(low(&group), [f32::MIN; 2]);
    }

    /// Chunks of a landscape whose meshes are generated anew have another number of triangles each time.
    #[test]
    fn meshes_of_other_sizes_leave_no_batches_behind() {
        let mut group = MeshGroup::new([const { None }; 3]);
        let mut places: Vec<_> = (0..20).map(|i| group.add(mesh(1000 + i), None)).collect();
        for step in 0..1000 {
            let triangles = 500 + (step * 7919) % 1000;
            let place = &mut places[step as usize % 20];
            group.remove(*place);
            *place = group.add(mesh(triangles), None);
            let used = places
                .iter()
                .map(|&place| group.instances.items[place].triangle_count);
            let used: usize = used.map(batch_count).sum();
            let most = 2 * used + MeshGroup::FEW_BATCHES + 100;
            assert!(group.batches.items.len() <= most);
            assert_eq!(group.batches.items.len() - group.idle_batches, used);
        }
        group.check(&places);
        group.compact();
        group.check(&places);
    }
}

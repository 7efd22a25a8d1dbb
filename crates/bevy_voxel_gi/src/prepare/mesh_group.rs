//! Meshes that share their buffers, and their lists on the GPU.

use std::{num::NonZeroU64, ops::Range};

use bevy::{
    platform::collections::HashMap,
    render::{
        render_resource::{
            BindingResource, Buffer, BufferBinding, BufferDescriptor, BufferUsages, ShaderSize,
            ShaderType,
            encase::{self, internal::WriteInto},
        },
        renderer::{RenderDevice, RenderQueue},
    },
};

use crate::gpu_types::{MeshInstance, TriangleBatch};

/// Number of triangles in a batch.
const BATCH_TRIANGLES: u32 = 64;

/// A bit for each level that a mesh may reach into.
pub(super) type LevelMask = u32;

/// Meshes that share their buffers.
pub(crate) struct MeshGroup {
    /// Vertices, indices and morph targets, if the meshes have them.
    pub buffers: [Option<Buffer>; 3],
    instances: List<MeshInstance>,
    batches: List<TriangleBatch>,
    /// The levels of each instance, none of those without a mesh.
    levels: Vec<LevelMask>,
    /// Places without a mesh, whose batches are those of a mesh with so many triangles in these levels.
    free: HashMap<(u32, LevelMask), Vec<usize>>,
    /// Number of their batches.
    idle_batches: usize,
    /// Places without a mesh and without batches.
    vacant: Vec<usize>,
    /// Number of meshes.
    count: usize,
}

/// Number of batches of a mesh.
fn batch_count(triangles: u32, levels: LevelMask) -> usize {
    (levels.count_ones() * triangles.div_ceil(BATCH_TRIANGLES)) as usize
}

impl MeshGroup {
    /// So few batches without a mesh are left alone.
    const FEW_BATCHES: usize = 64;

    pub(super) fn new(buffers: [Option<Buffer>; 3]) -> Self {
        Self {
            buffers,
            instances: List::new("voxel_gi_mesh_instances"),
            batches: List::new("voxel_gi_triangle_batches"),
            levels: Vec::new(),
            free: HashMap::default(),
            idle_batches: 0,
            vacant: Vec::new(),
            count: 0,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds a mesh to the levels that have a bit in the mask, and returns the place of its instance.
    pub(super) fn add(&mut self, instance: MeshInstance, levels: LevelMask) -> usize {
        self.count += 1;
        let triangles = instance.triangle_count;
        let free = self.free.get_mut(&(triangles, levels));
        let place = if let Some(place) = free.and_then(Vec::pop) {
            self.idle_batches -= batch_count(triangles, levels);
            place
        } else {
            let place = self.vacant.pop().unwrap_or(self.levels.len());
            self.push_batches(place, triangles, levels);
            place
        };
        if place == self.levels.len() {
            self.levels.push(levels);
            self.instances.push(instance);
        } else {
            self.levels[place] = levels;
            self.instances.set(place, instance);
        }
        place
    }

    fn push_batches(&mut self, place: usize, triangles: u32, levels: LevelMask) {
        let instance = u32::try_from(place).unwrap_or(u32::MAX);
        for level in (0..LevelMask::BITS).filter(|level| levels >> level & 1 == 1) {
            for first_triangle in (0..triangles).step_by(BATCH_TRIANGLES as usize) {
                self.batches.push(TriangleBatch {
                    instance,
                    first_triangle,
                    level,
                    pad: 0,
                });
            }
        }
    }

    /// Replaces an instance if it has as many triangles, and returns the former one.
    pub(super) fn replace(&mut self, place: usize, instance: MeshInstance) -> Option<MeshInstance> {
        let former = self.instances.items[place];
        let is_same = former.triangle_count == instance.triangle_count;
        is_same.then(|| {
            self.instances.set(place, instance);
            former
        })
    }

    /// Removes a mesh: its batches have no triangles until another one takes its place, or until they are more than
    /// those of meshes.
    pub(super) fn remove(&mut self, place: usize) -> MeshInstance {
        let removed = self.instances.items[place];
        let levels = std::mem::take(&mut self.levels[place]);
        let without_triangles = MeshInstance {
            triangle_count: 0,
            ..removed
        };
        self.instances.set(place, without_triangles);
        let free = self.free.entry((removed.triangle_count, levels));
        free.or_default().push(place);
        self.idle_batches += batch_count(removed.triangle_count, levels);
        self.count -= 1;
        let used = self.batches.items.len() - self.idle_batches;
        if self.idle_batches > used + Self::FEW_BATCHES {
            self.compact();
        }
        removed
    }

    /// Removes the batches without a mesh.
    fn compact(&mut self) {
        self.batches.clear();
        for place in 0..self.levels.len() {
            let triangles = self.instances.items[place].triangle_count;
            self.push_batches(place, triangles, self.levels[place]);
        }
        self.vacant
            .extend(self.free.drain().flat_map(|(_, places)| places));
        self.idle_batches = 0;
    }

    /// Writes what has changed, and returns instances, batches and the number of batches; `None` if there are none.
    pub(crate) fn upload(
        &mut self,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<(BindingResource<'_>, BindingResource<'_>, u32)> {
        let batch_count = u32::try_from(self.batches.items.len()).unwrap_or(u32::MAX);
        let instances = self.instances.upload(device, queue)?;
        let batches = self.batches.upload(device, queue)?;
        Some((instances, batches, batch_count))
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
        for places in runs(&self.changed) {
            let offset = places.start as u64 * size;
            queue.write_buffer(buffer, offset, &bytes(&self.items[places]));
        }
        self.changed.clear();
        Some(BindingResource::Buffer(BufferBinding {
            buffer,
            offset: 0,
            size: Some(bound),
        }))
    }
}

/// The most unchanged items between two changed ones that are written with them: each write has a price of its own.
const GAP: usize = 16;

/// Ranges that contain all of the sorted places.
fn runs(places: &[usize]) -> impl Iterator<Item = Range<usize>> {
    let chunks = places.chunk_by(|a, b| b - a <= GAP);
    chunks.map(|chunk| chunk[0]..chunk[chunk.len() - 1] + 1)
}

fn bytes(data: &(impl ShaderType + WriteInto + ?Sized)) -> Vec<u8> {
    let mut bytes = encase::StorageBuffer::new(Vec::new());
    bytes.write(data).expect("a vector grows");
    bytes.into_inner()
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
            ..MeshInstance::default()
        }
    }

    #[test]
    fn meshes_that_come_and_go_take_the_places_of_their_like() {
        let mut group = MeshGroup::new([const { None }; 3]);
        let places: Vec<_> = (0..10).map(|_| group.add(mesh(100), 0b101)).collect();
        assert_eq!(group.batches.items.len(), 10 * 2 * 2);
        for _ in 0..50 {
            assert_eq!(group.remove(places[3]).triangle_count, 100);
            assert_eq!(group.instances.items[places[3]].triangle_count, 0);
            assert_eq!(group.add(mesh(100), 0b101), places[3]);
        }
        assert_eq!(group.batches.items.len(), 10 * 2 * 2);
        group.remove(places[0]);
        assert_eq!(group.add(mesh(100), 0b001), 10, "other levels");
        assert_eq!(group.add(mesh(64), 0b101), 11, "other triangles");
        assert!(group.replace(1, mesh(64)).is_none() && group.replace(1, mesh(100)).is_some());
        for place in 1..10 {
            group.remove(place);
        }
        assert!(!group.is_empty());
        group.remove(10);
        group.remove(11);
        assert!(group.is_empty());
    }

    /// Chunks of a landscape whose meshes are generated anew have another number of triangles each time.
    #[test]
    fn meshes_of_other_sizes_leave_no_batches_behind() {
        let mut group = MeshGroup::new([const { None }; 3]);
        let mut places: Vec<_> = (0..20).map(|i| group.add(mesh(1000 + i), 0b11)).collect();
        for step in 0..1000 {
            let triangles = 500 + (step * 7919) % 1000;
            let place = &mut places[step as usize % 20];
            group.remove(*place);
            *place = group.add(mesh(triangles), 0b11);
            let used = places
                .iter()
                .map(|&place| group.instances.items[place].triangle_count);
            let used: usize = used.map(|triangles| batch_count(triangles, 0b11)).sum();
            let most = 2 * used + MeshGroup::FEW_BATCHES + 100;
            assert!(group.batches.items.len() <= most);
            assert_eq!(group.batches.items.len() - group.idle_batches, used);
        }
        // The batches of each mesh are there once.
        group.compact();
        for (i, place) in places.iter().enumerate() {
            let own = group
                .batches
                .items
                .iter()
                .filter(|batch| batch.instance as usize == *place);
            let triangles = group.instances.items[*place].triangle_count;
            assert_eq!(own.count(), batch_count(triangles, 0b11), "mesh {i}");
        }
    }
}

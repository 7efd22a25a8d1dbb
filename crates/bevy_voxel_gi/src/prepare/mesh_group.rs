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
    /// Places without a mesh, whose batches are those of a mesh with so many triangles in these levels.
    free: HashMap<(u32, LevelMask), Vec<usize>>,
    /// Number of meshes.
    count: usize,
}

impl MeshGroup {
    pub(super) fn new(buffers: [Option<Buffer>; 3]) -> Self {
        Self {
            buffers,
            instances: List::new("voxel_gi_mesh_instances"),
            batches: List::new("voxel_gi_triangle_batches"),
            free: HashMap::default(),
            count: 0,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds a mesh to the levels that have a bit in the mask, and returns the place of its instance.
    pub(super) fn add(&mut self, instance: MeshInstance, levels: LevelMask) -> usize {
        self.count += 1;
        let free = self.free.get_mut(&(instance.triangle_count, levels));
        if let Some(place) = free.and_then(Vec::pop) {
            self.instances.set(place, instance);
            return place;
        }
        let place = self.instances.items.len();
        let index = u32::try_from(place).unwrap_or(u32::MAX);
        for level in (0..LevelMask::BITS).filter(|level| levels >> level & 1 == 1) {
            for first_triangle in (0..instance.triangle_count).step_by(BATCH_TRIANGLES as usize) {
                self.batches.push(TriangleBatch {
                    instance: index,
                    first_triangle,
                    level,
                    pad: 0,
                });
            }
        }
        self.instances.push(instance);
        place
    }

    /// Replaces an instance if it has as many triangles, and returns whether it has.
    pub(super) fn replace(&mut self, place: usize, instance: MeshInstance) -> bool {
        let is_same = self.instances.items[place].triangle_count == instance.triangle_count;
        if is_same {
            self.instances.set(place, instance);
        }
        is_same
    }

    /// Removes a mesh from its levels: its batches have no triangles until another one takes its place.
    pub(super) fn remove(&mut self, place: usize, levels: LevelMask) -> MeshInstance {
        let removed = self.instances.items[place];
        let without_triangles = MeshInstance {
            triangle_count: 0,
            ..removed
        };
        self.instances.set(place, without_triangles);
        let free = self.free.entry((removed.triangle_count, levels));
        free.or_default().push(place);
        self.count -= 1;
        removed
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
            assert_eq!(group.remove(places[3], 0b101).triangle_count, 100);
            assert_eq!(group.instances.items[places[3]].triangle_count, 0);
            assert_eq!(group.add(mesh(100), 0b101), places[3]);
        }
        assert_eq!(group.batches.items.len(), 10 * 2 * 2);
        group.remove(places[0], 0b101);
        assert_eq!(group.add(mesh(100), 0b001), 10, "other levels");
        assert_eq!(group.add(mesh(64), 0b101), 11, "other triangles");
        assert!(!group.replace(1, mesh(64)) && group.replace(1, mesh(100)));
        for place in 1..10 {
            group.remove(place, 0b101);
        }
        assert!(!group.is_empty());
        group.remove(10, 0b001);
        group.remove(11, 0b101);
        assert!(group.is_empty());
    }
}

//! Meshes that share their buffers, and their lists on the GPU.

use std::num::NonZeroU64;

use bevy::{
    math::{Vec3, Vec3A},
    platform::collections::HashMap,
    render::{
        render_resource::{BindingResource, Buffer, BufferUsages, RawBufferVec},
        renderer::{RenderDevice, RenderQueue},
    },
};
use bytemuck::Pod;

use super::{
    buffers::{STORAGE, buffer, part_of},
    voxelization::Bounds,
};
use crate::gpu_types::{MESH_SKINNED, MeshBatch, MeshInstance};

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
    pub instances: UploadedList<'a>,
    pub batches: UploadedList<'a>,
    pub batch_count: u32,
    pub items: Buffer,
}

fn batch_count(triangles: u32) -> usize {
    triangles.div_ceil(BATCH_TRIANGLES) as usize
}

/// Number of batches of a mesh in all levels that it may reach into.
fn item_count(instance: &MeshInstance) -> usize {
    batch_count(instance.triangle_count) * instance.levels().count_ones() as usize
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

    /// Adds a mesh with these bounds in the world, if they are known, and returns the place of its instance.
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
        for batch in batches_of(place, instance, bounds) {
            self.batches.push(batch);
        }
        place
    }

    /// Gives all batches of a mesh its bounds.
    fn set_bounds(&mut self, place: usize, bounds: Option<Bounds>) {
        let batches = batches_of(place, self.instances.items[place], bounds);
        for (at, batch) in (self.first_batches[place]..).zip(batches) {
            self.batches.reset(at, batch);
        }
    }

    /// Replaces an instance if it has as many triangles, and returns the former one. `is_same_mesh` says whether these
    /// are where they were in the mesh's own space.
    pub(super) fn replace(
        &mut self,
        place: usize,
        instance: MeshInstance,
        bounds: Option<Bounds>,
        is_same_mesh: bool,
    ) -> Option<MeshInstance> {
        let former = self.instances.items[place];
        if former.triangle_count != instance.triangle_count {
            return None;
        }
        self.item_count += item_count(&instance);
        self.item_count -= item_count(&former);
        self.instances.set(place, instance);
        if is_deformed(&instance) || is_deformed(&former) || !is_same_mesh {
            self.set_bounds(place, bounds);
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
        let items =
            items.unwrap_or_else(|| buffer(device, "voxel_gi_triangle_items", needed, STORAGE));
        self.items = Some(items.clone());
        Some(UploadedGroup {
            instances: self.instances.upload(device, queue)?,
            batches: self.batches.upload(device, queue)?,
            batch_count,
            items,
        })
    }
}

fn is_deformed(instance: &MeshInstance) -> bool {
    instance.flags & MESH_SKINNED != 0 || instance.weight_count > 0
}

/// The batches of a mesh with these bounds in the world, if they are known: they have the same corners where it is
/// deformed; else the GPU finds those of each, in the mesh's own space.
fn batches_of(
    place: usize,
    instance: MeshInstance,
    bounds: Option<Bounds>,
) -> impl Iterator<Item = MeshBatch> {
    let [low, high] = if is_deformed(&instance) {
        let most = Vec3A::splat(f32::MAX);
        let (center, half_size) = bounds.unwrap_or((Vec3A::ZERO, most));
        [center - half_size, center + half_size].map(|corner| corner.clamp(-most, most).into())
    } else {
        [f32::MAX, f32::MIN].map(Vec3::splat)
    };
    let first_triangles = (0..instance.triangle_count).step_by(BATCH_TRIANGLES as usize);
    first_triangles.map(move |first_triangle| MeshBatch {
        low,
        instance: u32::try_from(place).unwrap_or(u32::MAX),
        high,
        first_triangle,
    })
}

/// Items, and their copy on the GPU.
struct List<T> {
    label: &'static str,
    items: Vec<T>,
    /// The copy, which may have room for more.
    buffer: Option<Buffer>,
    /// The words that have changed since they were copied, some of them more than once; `None` if all have.
    changed: Option<Vec<u32>>,
    /// Changed words for `ScatterPass`, each behind its place.
    changes: RawBufferVec<[u32; 2]>,
}

/// A list on the GPU.
pub(crate) struct UploadedList<'a> {
    pub items: BindingResource<'a>,
    /// The changed words that are to be written into it.
    pub changes: Option<BindingResource<'a>>,
    pub change_count: u32,
}

impl<T: Pod> List<T> {
    const WORDS: usize = size_of::<T>() / 4;

    fn new(label: &'static str) -> Self {
        Self {
            label,
            items: Vec::new(),
            buffer: None,
            changed: None,
            changes: RawBufferVec::new(BufferUsages::STORAGE),
        }
    }

    fn push(&mut self, item: T) {
        self.items.push(item);
        self.note(self.items.len() - 1, |_| true);
    }

    fn clear(&mut self) {
        self.items.clear();
        self.changed = None;
    }

    /// Sets an item that only the CPU writes.
    fn set(&mut self, place: usize, item: T) {
        let former = std::mem::replace(&mut self.items[place], item);
        let former: &[u32] = bytemuck::cast_slice(std::slice::from_ref(&former));
        let new: &[u32] = bytemuck::cast_slice(std::slice::from_ref(&item));
        self.note(place, |word| former[word] != new[word]);
    }

    /// Sets an item that the GPU may have written to.
    fn reset(&mut self, place: usize, item: T) {
        self.items[place] = item;
        self.note(place, |_| true);
    }

    /// Notes the words of an item that have changed.
    fn note(&mut self, place: usize, has_changed: impl Fn(usize) -> bool) {
        let most = Self::WORDS * self.items.len() / 4;
        let Some(changed) = &mut self.changed else {
            return;
        };
        let first = Self::WORDS * place;
        let words = (0..Self::WORDS).filter(|word| has_changed(*word));
        changed.extend(words.map(|word| (first + word) as u32));
        if changed.len() > most {
            self.changed = None;
        }
    }

    /// Writes what has changed, and returns the copy without its room; `None` if there are no items.
    fn upload(&mut self, device: &RenderDevice, queue: &RenderQueue) -> Option<UploadedList<'_>> {
        let needed = size_of_val(&self.items[..]) as u64;
        let bound = NonZeroU64::new(needed)?;
        let is_small = |buffer: &Buffer| buffer.size() < needed;
        if self.buffer.as_ref().is_none_or(is_small) {
            // Room for half as many more, where this one was too small.
            let room = match self.buffer {
                Some(_) => (self.items.len() / 2 * size_of::<T>()) as u64,
                None => 0,
            };
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            self.buffer = Some(buffer(device, self.label, needed + room, usage));
            self.changed = None;
        }
        let buffer = self.buffer.as_ref()?;
        self.changes.clear();
        match self.changed.replace(Vec::new()) {
            None => queue.write_buffer(buffer, 0, bytemuck::cast_slice(&self.items)),
            Some(mut changed) => {
                let words: &[u32] = bytemuck::cast_slice(&self.items);
                let changes = changed.iter().map(|&word| [word, words[word as usize]]);
                self.changes.extend(changes);
                self.changes.write_buffer(device, queue);
                changed.clear();
                self.changed = Some(changed);
            }
        }
        let change_count = self.changes.len() as u32;
        Some(UploadedList {
            items: part_of(buffer, 0, Some(bound)),
            changes: self.changes.buffer().and_then(|buffer| {
                let size = NonZeroU64::new(8 * u64::from(change_count))?;
                Some(part_of(buffer, 0, Some(size)))
            }),
            change_count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_types::MESH_LEVELS_SHIFT;

    fn mesh(triangle_count: u32) -> MeshInstance {
        MeshInstance {
            triangle_count,
            flags: 0b101 << MESH_LEVELS_SHIFT,
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
        assert!(group.replace(1, mesh(64), None, true).is_none());
        assert!(group.replace(1, mesh(100), None, true).is_some());
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
        let given = Some((Vec3A::ONE, Vec3A::splat(0.5)));
        let skinned = MeshInstance {
            flags: MESH_SKINNED | mesh(100).flags,
            ..mesh(100)
        };
        let place = group.add(mesh(100), given);
        let low = |group: &MeshGroup| [0, 1].map(|i| group.batches.items[i].low.x);
        assert_eq!(
            low(&group),
            [f32::MAX; 2],
            "the GPU finds those of rigid meshes"
        );
        let found = MeshBatch {
            low: Vec3::splat(0.25),
            ..group.batches.items[0]
        };
        group.batches.items[0] = found;
        group.replace(place, mesh(100), given, true);
        assert_eq!(low(&group), [0.25, f32::MAX]);
        group.replace(place, mesh(100), given, false);
        assert_eq!(low(&group), [f32::MAX; 2]);
        group.replace(place, skinned, given, true);
        assert_eq!(low(&group), [0.5; 2]);
        group.replace(place, skinned, None, true);
        assert_eq!(low(&group), [f32::MIN; 2], "anywhere");
        group.replace(place, mesh(100), given, true);
        assert_eq!(low(&group), [f32::MAX; 2], "it is rigid again");
    }

    /// The GPU's copy of a list after its changes.
    fn uploaded(list: &mut List<[u32; 2]>, before: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let Some(changed) = list.changed.replace(Vec::new()) else {
            return list.items.clone();
        };
        assert!(changed.len() <= list.items.len() / 2);
        let mut words: Vec<u32> = bytemuck::cast_slice(before).to_vec();
        words.resize(2 * list.items.len(), u32::MAX);
        for word in changed {
            words[word as usize] = list.items[word as usize / 2][word as usize % 2];
        }
        bytemuck::cast_slice(&words).to_vec()
    }

    #[test]
    fn a_list_on_the_gpu_is_that_of_the_cpu_whatever_is_written_when() {
        let mut list = List::new("list");
        let mut on_gpu = Vec::new();
        let mut state = 1_u32;
        for step in 0..3000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (place, value) = ((state >> 16) as usize, state >> 30);
            match step {
                0..40 => list.push([value; 2]),
                1500 => list.clear(),
                _ if list.items.len() < 40 || step % 97 == 0 => list.push([value; 2]),
                _ if step % 5 == 0 => list.reset(place % list.items.len(), [value, 7]),
                _ => list.set(place % list.items.len(), [value, 7]),
            }
            if step % 11 == 0 {
                on_gpu = uploaded(&mut list, &on_gpu);
                assert_eq!(on_gpu, list.items, "step {step}");
            }
        }
        let count = |list: &List<[u32; 2]>| list.changed.as_ref().map(Vec::len);
        uploaded(&mut list, &[]);
        let same = list.items[3];
        list.set(3, same);
        assert_eq!(count(&list), Some(0), "nothing has changed");
        list.set(3, [same[0] + 1, same[1]]);
        assert_eq!(count(&list), Some(1), "one word has");
        list.reset(4, list.items[4]);
        assert_eq!(count(&list), Some(3), "the GPU may have written both");
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

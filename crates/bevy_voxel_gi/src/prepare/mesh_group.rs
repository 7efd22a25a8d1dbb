//! Meshes that share their buffers, and their lists on the GPU.

use bevy::render::{
    render_resource::{
        Buffer, BufferInitDescriptor, BufferUsages, ShaderSize, ShaderType,
        encase::{self, internal::WriteInto},
    },
    renderer::{RenderDevice, RenderQueue},
};

use crate::gpu_types::{MeshInstance, TriangleBatch};

/// Number of triangles in a batch.
const BATCH_TRIANGLES: u32 = 64;

/// Meshes that share their buffers.
pub(crate) struct MeshGroup {
    /// Vertices, indices and morph targets, if the meshes have them.
    pub buffers: [Option<Buffer>; 3],
    instances: Vec<MeshInstance>,
    batches: Vec<TriangleBatch>,
    /// The lists on the GPU, once they are there.
    lists: Option<MeshLists>,
    /// Places of the instances that have changed since.
    changed: Vec<usize>,
}

/// Instances and batches on the GPU.
#[derive(Clone)]
pub(crate) struct MeshLists {
    pub instances: Buffer,
    pub batches: Buffer,
    pub batch_count: u32,
}

impl MeshGroup {
    pub(super) fn new(buffers: [Option<Buffer>; 3]) -> Self {
        Self {
            buffers,
            instances: Vec::new(),
            batches: Vec::new(),
            lists: None,
            changed: Vec::new(),
        }
    }

    /// Adds a mesh to the levels that have a bit in the mask, and returns the place of its instance.
    pub(super) fn add(&mut self, instance: MeshInstance, levels: u32) -> usize {
        let place = self.instances.len();
        let index = u32::try_from(place).unwrap_or(u32::MAX);
        for level in (0..u32::BITS).filter(|level| levels >> level & 1 == 1) {
            let first_triangles = (0..instance.triangle_count).step_by(BATCH_TRIANGLES as usize);
            self.batches
                .extend(first_triangles.map(|first_triangle| TriangleBatch {
                    instance: index,
                    first_triangle,
                    level,
                    pad: 0,
                }));
        }
        self.instances.push(instance);
        place
    }

    /// Replaces an instance if it has as many triangles, and returns whether it has.
    pub(super) fn replace(&mut self, place: usize, instance: MeshInstance) -> bool {
        let former = &mut self.instances[place];
        if former.triangle_count != instance.triangle_count {
            return false;
        }
        *former = instance;
        self.changed.push(place);
        true
    }

    /// Writes what has changed, and returns the lists; `None` if there are no triangles.
    pub(crate) fn upload(
        &mut self,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<MeshLists> {
        if self.batches.is_empty() {
            return None;
        }
        let lists = self.lists.get_or_insert_with(|| {
            self.changed.clear();
            MeshLists {
                instances: list(device, "voxel_gi_mesh_instances", &self.instances),
                batches: list(device, "voxel_gi_triangle_batches", &self.batches),
                batch_count: u32::try_from(self.batches.len()).unwrap_or(u32::MAX),
            }
        });
        // Each write has a price of its own.
        if self.changed.len() > self.instances.len() / 8 {
            queue.write_buffer(&lists.instances, 0, &bytes(&self.instances));
        } else {
            for place in &self.changed {
                let offset = *place as u64 * MeshInstance::SHADER_SIZE.get();
                queue.write_buffer(&lists.instances, offset, &bytes(&self.instances[*place]));
            }
        }
        self.changed.clear();
        Some(lists.clone())
    }
}

fn list<T: ShaderType + ShaderSize + WriteInto>(
    device: &RenderDevice,
    label: &str,
    items: &Vec<T>,
) -> Buffer {
    device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some(label),
        usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
        contents: &bytes(items),
    })
}

fn bytes(data: &(impl ShaderType + WriteInto)) -> Vec<u8> {
    let mut bytes = encase::StorageBuffer::new(Vec::new());
    bytes.write(data).expect("a vector grows");
    bytes.into_inner()
}

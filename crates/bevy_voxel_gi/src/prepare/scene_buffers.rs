//! The lights and materials of the scene, on the GPU.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ShaderSize, ShaderType, StorageBuffer, encase::internal::WriteInto},
        renderer::{RenderDevice, RenderQueue},
    },
};

use crate::{extract::voxel_material::VoxelMaterial, gpu_types::Light};

/// The lights and materials of the scene.
#[derive(Resource)]
pub(crate) struct SceneBuffers {
    pub materials: StorageBuffer<Vec<VoxelMaterial>>,
    pub lights: StorageBuffer<Vec<Light>>,
}

impl SceneBuffers {
    pub(super) fn new(
        materials: &[VoxelMaterial],
        lights: &[Light],
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Self {
        Self {
            materials: buffer(materials, VoxelMaterial::NEUTRAL, device, queue),
            lights: buffer(lights, Light::default(), device, queue),
        }
    }
}

/// A buffer of these items, or of `otherwise` alone, as buffers cannot be empty.
fn buffer<T: ShaderType + ShaderSize + WriteInto + Clone>(
    items: &[T],
    otherwise: T,
    device: &RenderDevice,
    queue: &RenderQueue,
) -> StorageBuffer<Vec<T>> {
    let mut buffer = StorageBuffer::from(if items.is_empty() {
        vec![otherwise]
    } else {
        items.to_vec()
    });
    buffer.write_buffer(device, queue);
    buffer
}

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
#[derive(Resource, Default)]
pub(crate) struct SceneBuffers {
    pub materials: StorageBuffer<Vec<VoxelMaterial>>,
    pub lights: StorageBuffer<Vec<Light>>,
}

impl SceneBuffers {
    pub(super) fn write(
        &mut self,
        materials: &[VoxelMaterial],
        lights: &[Light],
        device: &RenderDevice,
        queue: &RenderQueue,
    ) {
        write(
            &mut self.materials,
            materials,
            VoxelMaterial::NEUTRAL,
            device,
            queue,
        );
        write(&mut self.lights, lights, Light::default(), device, queue);
    }
}

/// Writes these items, or `otherwise` alone, as buffers cannot be empty.
fn write<T: ShaderType + ShaderSize + WriteInto + Clone>(
    buffer: &mut StorageBuffer<Vec<T>>,
    items: &[T],
    otherwise: T,
    device: &RenderDevice,
    queue: &RenderQueue,
) {
    let all = buffer.get_mut();
    all.clear();
    all.extend_from_slice(items);
    if items.is_empty() {
        all.push(otherwise);
    }
    buffer.write_buffer(device, queue);
}

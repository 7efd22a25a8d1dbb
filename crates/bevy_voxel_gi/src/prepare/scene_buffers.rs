//! The lights of the scene, on the GPU.

use bevy::{
    prelude::*,
    render::{
        render_resource::StorageBuffer,
        renderer::{RenderDevice, RenderQueue},
    },
};

use crate::gpu_types::Light;

/// The lights of the scene.
#[derive(Resource, Default)]
pub(crate) struct SceneBuffers {
    pub lights: StorageBuffer<Vec<Light>>,
}

impl SceneBuffers {
    /// Writes these lights, or one without light, as buffers cannot be empty.
    pub(super) fn write(&mut self, lights: &[Light], device: &RenderDevice, queue: &RenderQueue) {
        let all = self.lights.get_mut();
        all.clear();
        all.extend_from_slice(lights);
        if lights.is_empty() {
            all.push(Light::default());
        }
        self.lights.write_buffer(device, queue);
    }
}

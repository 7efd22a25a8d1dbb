//! The lights on the GPU.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ShaderType, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::settings::{LightSource, LightSources, MAX_SOURCES};

/// The uniform buffer of lights in `light.wesl`.
#[derive(Clone, Default, ShaderType)]
pub struct SourcesUniform {
    sources: [LightSource; MAX_SOURCES],
}

/// The lights' buffer and their number.
#[derive(Resource, Default)]
pub struct SourcesBuffer {
    /// All of them; unused ones are dark.
    pub buffer: UniformBuffer<SourcesUniform>,
    /// How many to draw.
    pub count: u32,
}

pub fn prepare(
    sources: Res<LightSources>,
    mut buffer: ResMut<SourcesBuffer>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let shown = &sources.0[..sources.0.len().min(MAX_SOURCES)];
    let mut uniform = SourcesUniform::default();
    uniform.sources[..shown.len()].copy_from_slice(shown);
    buffer.count = shown.len() as u32;
    buffer.buffer.set(uniform);
    buffer.buffer.write_buffer(&device, &queue);
}

//! The lamps on the GPU.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ShaderType, UniformBuffer},
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::settings::{Lamp, Lamps, MAX_LAMPS};

/// The uniform buffer of lights in `light.wesl`.
#[derive(Clone, Default, ShaderType)]
pub struct LampsUniform {
    lamps: [Lamp; MAX_LAMPS],
}

/// The lamps' buffer and their number.
#[derive(Resource, Default)]
pub struct LampsBuffer {
    /// All of them; unused ones are dark.
    pub buffer: UniformBuffer<LampsUniform>,
    /// How many to draw.
    pub count: u32,
}

/// Writes the lamps of this frame.
pub fn prepare(
    lamps: Res<Lamps>,
    mut buffer: ResMut<LampsBuffer>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let shown = &lamps.0[..lamps.0.len().min(MAX_LAMPS)];
    let mut uniform = LampsUniform::default();
    uniform.lamps[..shown.len()].copy_from_slice(shown);
    buffer.count = shown.len() as u32;
    buffer.buffer.set(uniform);
    buffer.buffer.write_buffer(&device, &queue);
}

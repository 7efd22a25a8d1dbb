//! The number of textures that a material binds, which devices limit.
//!
//! The layout of a bind group is the same for all materials of a type, so it has the textures of all planes that a map
//! may have. Where a device has a lower limit, it has one texture for each map, and the loader decodes those textures
//! that have more.

use bevy::{
    pbr::StandardMaterial,
    render::{
        render_resource::{AsBindGroup, BindGroupLayoutEntry, BindingType, ShaderStages},
        renderer::RenderDevice,
    },
};

/// Textures that a view of Bevy 0.20 has at most in a fragment shader (`mesh_view_bindings.rs`), and a lightmap.
const BEVYS_TEXTURES: u32 = 17 + 1;

/// The limit of a device that is too low for all planes, and the number of textures that they need.
pub(crate) fn missing_textures(device: &RenderDevice, planes: u32) -> Option<[u32; 2]> {
    let limit = device.limits().max_sampled_textures_per_shader_stage;
    let base = StandardMaterial::bind_group_layout_entries(device, true);
    let needed = BEVYS_TEXTURES + textures(&base) + planes;
    (needed > limit).then_some([limit, needed])
}

fn textures(entries: &[BindGroupLayoutEntry]) -> u32 {
    let is_texture = |entry: &&BindGroupLayoutEntry| {
        matches!(entry.ty, BindingType::Texture { .. })
            && entry.visibility.contains(ShaderStages::FRAGMENT)
    };
    entries.iter().filter(is_texture).count() as u32
}

//! The patches of Bevy's shaders: one reads a volume in its own layout, the other lets it light lightmapped meshes.

use bevy_frugal_hooks::{Insertion, ShaderPatch};

/// Name of the patch of Bevy's irradiance volume shader.
pub(crate) const RECEIVER_PATCH: &str = "bevy_voxel_gi/receive";

pub(crate) fn receiver_patch() -> ShaderPatch {
    ShaderPatch {
        imports: vec![
            "bevy_voxel_gi::receive::receive::is_voxel_gi",
            "bevy_voxel_gi::receive::receive::voxel_gi_light",
        ],
        insertions: vec![Insertion::before(
            "        let atlas_resolution = vec3<f32>(",
            "        if (is_voxel_gi(irradiance_volume_texture)) {\n            \
             let place = (query_result.light_from_world * vec4(world_position, 1.0)).xyz;\n            \
             total_irradiance += voxel_gi_light(irradiance_volume_texture, \
             irradiance_volume_sampler, place, N, world_position)\n                \
             * query_result.intensity * query_result.weight;\n            \
             total_weight += query_result.weight;\n            \
             continue;\n        }",
        )],
        ..ShaderPatch::new(RECEIVER_PATCH, "bevy_pbr::light_probe::irradiance_volume")
    }
}

/// Name of the patch of Bevy's lighting.
pub(crate) const LIGHTMAP_PATCH: &str = "bevy_voxel_gi/lightmaps";

/// Bevy 0.20 reads no irradiance volume where there is a lightmap, whatever the volume says.
pub(crate) fn lightmap_patch() -> ShaderPatch {
    ShaderPatch {
        imports: vec!["bevy_voxel_gi::receive::features::LIGHTMAPPED"],
        insertions: vec![Insertion::before(
            "    @if(IRRADIANCE_VOLUME)\n    // Irradiance volume light (indirect)",
            "    @if(LIGHTMAP)\n    found_diffuse_indirect = !LIGHTMAPPED;",
        )],
        ..ShaderPatch::new(LIGHTMAP_PATCH, "bevy_pbr::render::pbr_functions")
    }
}

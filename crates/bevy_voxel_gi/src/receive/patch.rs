//! The patch of Bevy's irradiance volume shader, which reads a volume in its own layout.

use bevy_frugal_hooks::{Insertion, ShaderPatch};

/// Name of the patch of Bevy's irradiance volume shader.
pub(crate) const RECEIVER_PATCH: &str = "bevy_voxel_gi/receive";

pub(crate) fn patch() -> ShaderPatch {
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

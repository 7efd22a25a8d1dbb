//! The patches of Bevy's shaders: one reads a volume in its own layout, the other has it share diffuse light with Bevy's
//! other sources.

use bevy_frugal_hooks::{Insertion, ShaderPatch};

/// Name of the patch of Bevy's irradiance volume shader.
pub(crate) const RECEIVER_PATCH: &str = "bevy_voxel_gi/receive";

pub(crate) fn receiver_patch() -> ShaderPatch {
    ShaderPatch {
        imports: vec![
            "bevy_voxel_gi::receive::coverage::covered",
            "bevy_voxel_gi::receive::receive::is_voxel_gi",
            "bevy_voxel_gi::receive::receive::voxel_gi_light",
        ],
        insertions: vec![
            Insertion::before(
                "        let atlas_resolution = vec3<f32>(",
                "        if (is_voxel_gi(irradiance_volume_texture)) {\n            \
                 let place = (query_result.light_from_world * vec4(world_position, 1.0)).xyz;\n            \
                 let found = voxel_gi_light(irradiance_volume_texture, \
                 irradiance_volume_sampler, place, N, world_position);\n            \
                 let found_weight = query_result.weight * found.a;\n            \
                 total_irradiance += found.rgb * query_result.intensity * found_weight;\n            \
                 total_weight += found_weight;\n            \
                 continue;\n        }",
            ),
            Insertion::between(
                "        total_irradiance /= total_weight;\n    }\n\n",
                "    return total_irradiance;",
                "    total_irradiance = covered(total_irradiance, total_weight);",
            ),
        ],
        ..ShaderPatch::new(RECEIVER_PATCH, "bevy_pbr::light_probe::irradiance_volume")
    }
}

/// Name of the patch of Bevy's lighting.
pub(crate) const LIGHTING_PATCH: &str = "bevy_voxel_gi/lighting";

/// Bevy 0.20 has no diffuse light of environment maps on any pixel while there is an irradiance volume in view, adds
/// ambient light to that of volumes, and reads no volume where there is a lightmap, whatever the volume says.
pub(crate) fn lighting_patch() -> ShaderPatch {
    ShaderPatch {
        imports: vec![
            "bevy_voxel_gi::receive::coverage::uncovered",
            "bevy_voxel_gi::receive::features::LIGHTMAPPED",
            "bevy_voxel_gi::receive::features::VOXEL_GI",
        ],
        insertions: vec![
            Insertion::before(
                "    @if(IRRADIANCE_VOLUME)\n    // Irradiance volume light (indirect)",
                "    @if(LIGHTMAP)\n    found_diffuse_indirect = !LIGHTMAPPED;",
            ),
            Insertion::after(
                "        indirect_light += irradiance_volume_light * diffuse_color * diffuse_occlusion;\n        \
                 found_diffuse_indirect = true;",
                "\n        found_diffuse_indirect = !VOXEL_GI || uncovered() <= 0.0;",
            ),
            Insertion::between(
                "    indirect_light += environment_light.diffuse",
                " * diffuse_occlusion;",
                " * uncovered()",
            ),
            Insertion::between(
                "    indirect_light += ambient::ambient_light(in.world_position, in.N, in.V, NdotV, diffuse_color",
                ", F0, perceptual_roughness, diffuse_occlusion);",
                " * uncovered()",
            ),
        ],
        ..ShaderPatch::new(LIGHTING_PATCH, "bevy_pbr::render::pbr_functions")
    }
}

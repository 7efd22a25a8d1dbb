//! The patches of Bevy's shaders: one reads a volume in its own layout, and the others have it share diffuse and specular
//! light with Bevy's other sources.

use bevy_frugal_hooks::{Insertion, ShaderPatch};

/// Name of the patch of Bevy's irradiance volume shader.
pub(crate) const RECEIVER_PATCH: &str = "bevy_voxel_gi/receive";

pub(crate) fn receiver_patch() -> ShaderPatch {
    ShaderPatch {
        imports: vec![
            "bevy_voxel_gi::receive::coverage::covered",
            "bevy_voxel_gi::receive::features::LIGHTMAPPED",
            "bevy_voxel_gi::receive::receive::is_voxel_gi",
            "bevy_voxel_gi::receive::receive::only_volume_light",
            "bevy_voxel_gi::receive::receive::voxel_gi_light",
            "bevy_voxel_gi::receive::volume::IS_ONLY_VOLUME",
            "bevy_voxel_gi::receive::specular::set_reflected",
        ],
        insertions: vec![
            Insertion::before(
                "    // Find all irradiance volumes that contain the fragment.",
                "    if (IS_ONLY_VOLUME) {\n        \
                 @if(LIGHTMAP)\n        \
                 if (!LIGHTMAPPED) {\n            \
                 return vec3(0.0);\n        \
                 }\n        \
                 return only_volume_light(world_position, N);\n    \
                 }\n",
            ),
            Insertion::before(
                "        let atlas_resolution = vec3<f32>(",
                "        if (is_voxel_gi(query_result.texture_index)) {\n            \
                 let place = (query_result.light_from_world * vec4(world_position, 1.0)).xyz;\n            \
                 let found = voxel_gi_light(place, N);\n            \
                 let found_weight = query_result.weight * found.a;\n            \
                 set_reflected(found.rgb, query_result.intensity, found_weight);\n            \
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
            "bevy_voxel_gi::receive::plane::set_viewer",
            "bevy_voxel_gi::receive::specular::forget_reflected",
            "bevy_voxel_gi::receive::specular::reflected_light",
            "bevy_voxel_gi::receive::specular::set_lobe",
        ],
        insertions: vec![
            Insertion::before(
                "    @if(IRRADIANCE_VOLUME)\n    // Irradiance volume light (indirect)",
                "    @if(LIGHTMAP)\n    found_diffuse_indirect = !LIGHTMAPPED;",
            ),
            Insertion::before(
                "        let irradiance_volume_light = irradiance_volume::irradiance_volume_light(",
                "        set_viewer(in.V);\n        set_lobe(in.N, in.V, perceptual_roughness);",
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
            Insertion::before(
                "    // Ambient light (indirect)\n",
                "@if(!ENVIRONMENT_MAP) {\n    \
                 @if(SCREEN_SPACE_REFLECTIONS)\n    \
                 let is_of_screen = perceptual_roughness <= view_bindings::ssr_settings.max_perceptual_roughness\n        \
                 && perceptual_roughness >= view_bindings::ssr_settings.min_perceptual_roughness;\n    \
                 @else\n    \
                 let is_of_screen = false;\n    \
                 if (!is_of_screen) {\n        \
                 indirect_light += reflected_light(F0, F_ab) * specular_occlusion;\n    \
                 }\n}\n    \
                 forget_reflected();",
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

/// Name of the patch of Bevy's environment maps.
pub(crate) const ENVIRONMENT_PATCH: &str = "bevy_voxel_gi/environment_map";

/// The base layer of rough surfaces reflects the volume's light in place of that of environment maps.
pub(crate) fn environment_patch() -> ShaderPatch {
    ShaderPatch {
        imports: vec![
            "bevy_voxel_gi::receive::specular::has_reflected",
            "bevy_voxel_gi::receive::specular::with_reflected",
        ],
        insertions: vec![
            Insertion::between(
                "all(radiances.radiance == vec3(0.0))",
                ") {",
                " && !has_reflected()",
            ),
            Insertion::between(
                "    out.specular = FssEss * ",
                "radiances.radiance;",
                "with_reflected(",
            ),
            Insertion::between(
                "radiances.radiance",
                ";\n\n    @if(STANDARD_MATERIAL_CLEARCOAT)",
                ")",
            ),
        ],
        ..ShaderPatch::new(ENVIRONMENT_PATCH, "bevy_pbr::light_probe::environment_map")
    }
}

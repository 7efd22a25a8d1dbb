//! Inserts a call beside each `textureSampleBias` of Bevy's material shaders, compiled under the
//! feature `BEVY_EWA`.
//!
//! Nothing is replaced: the call becomes another branch of the `@if` around Bevy's own statement. That
//! whole statement is the anchor, and the number of `textureSampleBias` calls is verified.

use bevy::prelude::*;
use bevy_frugal_hooks::{Insertion, ShaderPatch, ShaderPatches};

/// Name of the patch for the maps in the forward and the deferred pass.
pub const FRAGMENT: &str = "bevy_ewa/fragment";
/// Name of the patch for the normal map in the prepass.
pub const PREPASS: &str = "bevy_ewa/prepass";
/// Name of the patch for the base colour's alpha in the prepass and shadow passes.
pub const ALPHA: &str = "bevy_ewa/alpha";

/// The patches that must all be applied: without one, passes would filter the same map differently.
pub const REQUIRED: &[&str] = &[FRAGMENT, PREPASS, ALPHA];

/// Whether all required patches are applied to Bevy's shaders.
pub(crate) fn is_patched(patches: Option<Res<ShaderPatches>>) -> bool {
    patches.is_some_and(|patches| patches.all_applied(REQUIRED))
}

/// Whether one of Bevy's shaders could not be patched. The plugin then leaves all materials to Bevy,
/// since the passes would otherwise filter the same map differently.
pub(super) fn is_refused(patches: Option<Res<ShaderPatches>>) -> bool {
    patches.is_some_and(|patches| patches.refused(REQUIRED).is_some())
}

const SAMPLING: &str = "textureSampleBias(";

/// Returns all patches.
pub fn patches() -> Vec<ShaderPatch> {
    vec![fragment(), prepass(), alpha()]
}

/// A patch of a shader with exactly `samplings` calls of `textureSampleBias`.
fn patch(
    name: &'static str,
    shader: &'static str,
    samplings: usize,
    insertions: Vec<Insertion>,
) -> ShaderPatch {
    ShaderPatch {
        imports: vec!["bevy_ewa::material::sample_map::sample_map"],
        expected_counts: vec![(SAMPLING, samplings)],
        insertions,
        ..ShaderPatch::new(name, shader)
    }
}

/// Inserts a branch before the last one around a `textureSampleBias` of the fragment shader. The first
/// literal is the feature that selects the second UV set.
macro_rules! map {
    ($uv_b:literal, $statement:literal) => {
        Insertion::before(
            concat!("@else\n", $statement),
            format!(
                "@elif(BEVY_EWA && {})\n{}\n@elif(BEVY_EWA)\n{}",
                $uv_b,
                $statement.replace(SAMPLING, "sample_map(ewa_gradient_b, "),
                $statement.replace(SAMPLING, "sample_map(ewa_gradient, "),
            ),
        )
    };
}

#[rustfmt::skip] // One line per map.
fn fragment() -> ShaderPatch {
    let maps = vec![
        // Derivatives are taken before parallax mapping, whose coordinates jump at silhouettes.
        Insertion::before(
            "@if(VERTEX_UVS && VERTEX_TANGENTS)\n    if ((flags & pbr_types::STANDARD_MATERIAL_FLAGS_DEPTH_MAP_BIT) != 0u) {",
            "@if(BEVY_EWA && VERTEX_UVS && VERTEX_UVS_A)\n    let ewa_gradient = vec4(dpdx(uv), dpdy(uv));\n\
             @if(BEVY_EWA && VERTEX_UVS)\n    let ewa_gradient_b = vec4(dpdx(uv_b), dpdy(uv_b));",
        ),
        map!("STANDARD_MATERIAL_BASE_COLOR_UV_B", "        pbr_input.material.base_color *= textureSampleBias(texture, sampler_, coords, bias.mip_bias);"),
        map!("STANDARD_MATERIAL_SPECULAR_UV_B", "            let specular = textureSampleBias(texture, sampler_, coords, bias.mip_bias).a;"),
        map!("STANDARD_MATERIAL_SPECULAR_TINT_UV_B", "            let specular_tint = textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb;"),
        map!("STANDARD_MATERIAL_EMISSIVE_UV_B", "            emissive = vec4<f32>(emissive.rgb * textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb, emissive.a);"),
        map!("STANDARD_MATERIAL_METALLIC_ROUGHNESS_UV_B", "            let metallic_roughness = textureSampleBias(texture, sampler_, coords, bias.mip_bias);"),
        map!("STANDARD_MATERIAL_CLEARCOAT_UV_B", "            pbr_input.material.clearcoat *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).r;"),
        map!("STANDARD_MATERIAL_CLEARCOAT_ROUGHNESS_UV_B", "            pbr_input.material.clearcoat_perceptual_roughness *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).g;"),
        map!("STANDARD_MATERIAL_SPECULAR_TRANSMISSION_UV_B", "            specular_transmission *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).r;"),
        map!("STANDARD_MATERIAL_THICKNESS_UV_B", "            thickness *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).g;"),
        map!("STANDARD_MATERIAL_DIFFUSE_TRANSMISSION_UV_B", "            diffuse_transmission *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).a;"),
        map!("STANDARD_MATERIAL_OCCLUSION_UV_B", "            diffuse_occlusion *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).r;"),
        map!("STANDARD_MATERIAL_NORMAL_MAP_UV_B", "        let Nt = textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb;"),
        map!("STANDARD_MATERIAL_CLEARCOAT_NORMAL_UV_B", "        let clearcoat_Nt = textureSampleBias(clearcoat_texture, clearcoat_sampler, clearcoat_coords, bias.mip_bias).rgb;"),
        map!("STANDARD_MATERIAL_ANISOTROPY_UV_B", "            let anisotropy_texel = textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb;"),
    ];
    patch(FRAGMENT, "bevy_pbr::render::pbr_fragment", 14, maps)
}

fn prepass() -> ShaderPatch {
    let statement = "\n        let Nt =\n            textureSampleBias(";
    patch(
        PREPASS,
        "bevy_pbr::render::pbr_prepass",
        1,
        vec![
            Insertion::between(
                "@if(!MESHLET_MESH_MATERIAL_PASS)",
                statement,
                "{ @if(BEVY_EWA)\n\
                 let Nt = sample_map(vec4(dpdx(uv), dpdy(uv)), texture, sampler_, uv, \
                 bias.mip_bias).rgb;\n@else",
            ),
            Insertion::between(
                "                bias.mip_bias,\n            ).rgb;",
                "\n        let TBN =",
                "}",
            ),
        ],
    )
}

fn alpha() -> ShaderPatch {
    let call = "sample_map(vec4(dpdx(uv), dpdy(uv)), texture, sampler_, uv, view.mip_bias)";
    patch(
        ALPHA,
        "bevy_pbr::render::pbr_prepass_functions",
        1,
        vec![Insertion::before(
            "        output_color = output_color * textureSampleBias(\n            texture,\n            \
             sampler_,\n            uv,\n            view.mip_bias\n        );",
            format!("@if(BEVY_EWA)\n        output_color *= {call};\n@else"),
        )],
    )
}

//! Inserts a statement beside each `textureSampleBias` of Bevy's material shaders, compiled under the
//! features `EWA_SHARED_*` and `EWA_OWN_*`, and where the texture coordinates are known the one call that
//! filters all maps that share size and coordinates.
//!
//! Nothing is replaced: the statement becomes another branch of the `@if` around Bevy's own statement. That
//! whole statement is the anchor, and the number of `textureSampleBias` calls is verified.

use bevy::prelude::*;
use bevy_frugal_hooks::{Insertion, ShaderPatch, ShaderPatches};

use crate::settings::EwaMaps;

/// Name of the patch for the maps in the forward and the deferred pass.
pub const FRAGMENT: &str = "bevy_ewa/fragment";
/// Name of the patch for the normal map in the prepass.
pub const PREPASS: &str = "bevy_ewa/prepass";
/// Name of the patch for the base colour's alpha in the prepass and shadow passes.
pub const ALPHA: &str = "bevy_ewa/alpha";

/// All patches.
pub const ALL: &[&str] = &[FRAGMENT, PREPASS, ALPHA];

/// The patches that do not fit Bevy's shaders.
///
/// A map is filtered in all passes that sample it or in none of them, since depth, normals and colours of one surface
/// would not agree otherwise. So a map without one of its patches is left to the texture unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Refused {
    fragment: bool,
    prepass: bool,
    alpha: bool,
}

impl Refused {
    pub(super) fn new(patches: &ShaderPatches) -> Self {
        let is_refused = |name: &str| patches.refused(&[name]).is_some();
        Self {
            fragment: is_refused(FRAGMENT),
            prepass: is_refused(PREPASS),
            alpha: is_refused(ALPHA),
        }
    }

    /// The chosen maps that can be filtered in a material.
    pub(super) fn filterable(self, chosen: EwaMaps, material: &StandardMaterial) -> EwaMaps {
        if self.fragment {
            return EwaMaps::NONE;
        }
        // Passes without colours sample the base colour only where its alpha cuts holes.
        let has_holes = material.alpha_mode != AlphaMode::Opaque;
        EwaMaps {
            base_color: chosen.base_color && !(self.alpha && has_holes),
            normals: chosen.normals && !self.prepass,
            ..chosen
        }
    }
}

const SAMPLING: &str = "textureSampleBias(";
/// The call at the maps that can share a loop.
const SHARABLE_SAMPLING: &str = "textureSampleBias(texture, sampler_, coords, bias.mip_bias)";
const SAMPLE_MAP: &str = "bevy_ewa::material::sample_map::sample_map";
const SHARED_MAPS: &str = "bevy_ewa::material::shared_maps::shared_maps";

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
        imports: vec![SAMPLE_MAP],
        expected_counts: vec![(SAMPLING, samplings)],
        insertions,
        ..ShaderPatch::new(name, shader)
    }
}

/// Inserts the branches of a map before Bevy's own statement. The field of the shared maps is in small letters.
macro_rules! map {
    ($map:literal, $field:literal, $statement:literal) => {
        Insertion::before(concat!("@else\n", $statement), {
            let mut text = String::new();
            if !$field.is_empty() {
                let shared = $statement.replace(SHARABLE_SAMPLING, concat!("ewa_maps.", $field));
                text = format!("@elif(EWA_SHARED_{})\n{shared}\n", $map);
            }
            text + &own_branches($map, $statement)
        })
    };
}

/// The branches of a map with a loop of its own. Bindless textures and samplers are given as numbers.
fn own_branches(map: &str, statement: &str) -> String {
    let bound = if statement.contains("clearcoat_texture") {
        "clearcoat_texture, clearcoat_sampler"
    } else {
        "texture, sampler_"
    };
    let second_uv = format!(" && STANDARD_MATERIAL_{map}_UV_B");
    let branch = |uv: &str, gradient: &str, bindless: &str, texture: &str| {
        let sampling = format!("sample_map(in.position.xy, {gradient}, {texture}");
        let statement = statement.replace(&format!("{SAMPLING}{bound}"), &sampling);
        format!("@elif(EWA_OWN_{map}{uv}{bindless})\n{statement}\n")
    };
    let numbers = numbers(&map.to_lowercase());
    let coordinates = [(second_uv.as_str(), "ewa_gradient_b"), ("", "ewa_gradient")];
    let branches = coordinates.map(|(uv, gradient)| {
        branch(uv, gradient, " && BINDLESS", &numbers) + &branch(uv, gradient, "", bound)
    });
    branches.concat().trim_end().into()
}

/// The numbers of a map's texture and sampler in Bevy's arrays.
fn numbers(map: &str) -> String {
    format!("material_indices[slot].{map}_texture, material_indices[slot].{map}_sampler")
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
        // A loop needs the fewest registers before Bevy has computed what it needs after it.
        Insertion::before(
            "    var pbr_input: pbr_types::PbrInput = pbr_input_from_vertex_output(in, is_front, double_sided);",
            "@if(EWA_SHARED_EARLY && VERTEX_UVS && BINDLESS)\n    \
                 let ewa_transform = pbr_bindings::material_array[material_indices[slot].material].uv_transform;\n\
             @elif(EWA_SHARED_EARLY && VERTEX_UVS)\n    \
                 let ewa_transform = pbr_bindings::material.uv_transform;\n\
             @if(EWA_SHARED_EARLY && EWA_SHARED_UV_B && VERTEX_UVS && VERTEX_UVS_B)\n    \
                 let ewa_uv = (ewa_transform * vec3(in.uv_b, 1.0)).xy;\n\
             @elif(EWA_SHARED_EARLY && VERTEX_UVS)\n    \
                 let ewa_uv = (ewa_transform * vec3(in.uv, 1.0)).xy;\n\
             @if(EWA_SHARED_EARLY && VERTEX_UVS)\n    \
                 let ewa_maps = shared_maps(in.position.xy, slot, vec4(dpdx(ewa_uv), dpdy(ewa_uv)), ewa_uv, view.mip_bias);",
        ),
        // After parallax mapping, which changes the coordinates.
        Insertion::before(
            "@if(VERTEX_UVS)\n    if ((flags & pbr_types::STANDARD_MATERIAL_FLAGS_BASE_COLOR_TEXTURE_BIT) != 0u) {",
            "@if(EWA_SHARED && !EWA_SHARED_EARLY && EWA_SHARED_UV_B && VERTEX_UVS)\n    \
                 let ewa_maps = shared_maps(in.position.xy, slot, ewa_gradient_b, uv_b, bias.mip_bias);\n\
             @elif(EWA_SHARED && !EWA_SHARED_EARLY && VERTEX_UVS)\n    \
                 let ewa_maps = shared_maps(in.position.xy, slot, ewa_gradient, uv, bias.mip_bias);",
        ),
        map!("BASE_COLOR", "base_color", "        pbr_input.material.base_color *= textureSampleBias(texture, sampler_, coords, bias.mip_bias);"),
        map!("SPECULAR", "", "            let specular = textureSampleBias(texture, sampler_, coords, bias.mip_bias).a;"),
        map!("SPECULAR_TINT", "", "            let specular_tint = textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb;"),
        map!("EMISSIVE", "emissive", "            emissive = vec4<f32>(emissive.rgb * textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb, emissive.a);"),
        map!("METALLIC_ROUGHNESS", "metallic_roughness", "            let metallic_roughness = textureSampleBias(texture, sampler_, coords, bias.mip_bias);"),
        map!("CLEARCOAT", "", "            pbr_input.material.clearcoat *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).r;"),
        map!("CLEARCOAT_ROUGHNESS", "", "            pbr_input.material.clearcoat_perceptual_roughness *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).g;"),
        map!("SPECULAR_TRANSMISSION", "", "            specular_transmission *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).r;"),
        map!("THICKNESS", "", "            thickness *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).g;"),
        map!("DIFFUSE_TRANSMISSION", "", "            diffuse_transmission *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).a;"),
        map!("OCCLUSION", "occlusion", "            diffuse_occlusion *= textureSampleBias(texture, sampler_, coords, bias.mip_bias).r;"),
        map!("NORMAL_MAP", "normal_map", "        let Nt = textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb;"),
        map!("CLEARCOAT_NORMAL", "", "        let clearcoat_Nt = textureSampleBias(clearcoat_texture, clearcoat_sampler, clearcoat_coords, bias.mip_bias).rgb;"),
        map!("ANISOTROPY", "", "            let anisotropy_texel = textureSampleBias(texture, sampler_, coords, bias.mip_bias).rgb;"),
    ];
    ShaderPatch {
        imports: vec![SAMPLE_MAP, SHARED_MAPS],
        ..patch(FRAGMENT, "bevy_pbr::render::pbr_fragment", 14, maps)
    }
}

fn prepass() -> ShaderPatch {
    let statement = "\n        let Nt =\n            textureSampleBias(";
    let normal = |texture: &str| {
        format!(
            "let Nt = sample_map(in.position.xy, vec4(dpdx(uv), dpdy(uv)), {texture}, uv, bias.mip_bias).rgb;"
        )
    };
    patch(
        PREPASS,
        "bevy_pbr::render::pbr_prepass",
        1,
        vec![
            Insertion::between(
                "@if(!MESHLET_MESH_MATERIAL_PASS)",
                statement,
                format!(
                    "{{ @if(EWA_OWN_NORMAL_MAP && BINDLESS)\n{}\n@elif(EWA_OWN_NORMAL_MAP)\n{}\n@else",
                    normal(&numbers("normal_map")),
                    normal("texture, sampler_")
                ),
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
    let filtered = |texture: &str| {
        format!(
            "output_color *= sample_map(in.position.xy, vec4(dpdx(uv), dpdy(uv)), {texture}, uv, view.mip_bias);"
        )
    };
    patch(
        ALPHA,
        "bevy_pbr::render::pbr_prepass_functions",
        1,
        vec![Insertion::before(
            "        output_color = output_color * textureSampleBias(\n            texture,\n            \
             sampler_,\n            uv,\n            view.mip_bias\n        );",
            format!(
                "@if(EWA_OWN_BASE_COLOR && BINDLESS)\n{}\n@elif(EWA_OWN_BASE_COLOR)\n{}\n@else",
                filtered(&numbers("base_color")),
                filtered("texture, sampler_")
            ),
        )],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_patch_leaves_the_maps_that_need_it() {
        let opaque = StandardMaterial::default();
        let masked = StandardMaterial {
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        };
        let refused = |patch: &str| Refused {
            fragment: patch == FRAGMENT,
            prepass: patch == PREPASS,
            alpha: patch == ALPHA,
        };
        let without_normals = EwaMaps {
            normals: false,
            ..EwaMaps::ALL
        };
        let without_base_color = EwaMaps {
            base_color: false,
            ..EwaMaps::ALL
        };
        for (patch, material, expected) in [
            ("none", &masked, EwaMaps::ALL),
            (FRAGMENT, &opaque, EwaMaps::NONE),
            (PREPASS, &opaque, without_normals),
            (ALPHA, &opaque, EwaMaps::ALL),
            (ALPHA, &masked, without_base_color),
        ] {
            let actual = refused(patch).filterable(EwaMaps::ALL, material);
            assert_eq!(actual, expected, "{patch} {:?}", material.alpha_mode);
        }
    }
}

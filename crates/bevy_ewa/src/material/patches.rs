//! A call beside each `textureSampleBias` of Bevy's material shaders, taken under the shader def
//! `BEVY_EWA`.
//!
//! Nothing is replaced: the call and the name of Bevy's function stand in the branches of an
//! `#ifdef`, and the arguments that follow serve both, with the derivatives as one more in front.

use bevy_frugal_hooks::{Insertion, ShaderName, ShaderPatch};

/// The maps in the forward and the deferred pass.
pub const FRAGMENT: &str = "bevy_ewa/fragment";
/// The normal map in the prepass.
pub const PREPASS: &str = "bevy_ewa/prepass";
/// The alpha of the base colour in prepass and shadows.
pub const ALPHA: &str = "bevy_ewa/alpha";

/// All of them: without one, passes would disagree about a map.
pub const REQUIRED: &[&str] = &[FRAGMENT, PREPASS, ALPHA];

const IMPORT: &str = "#ifdef BEVY_EWA\n#import bevy_ewa::material::sample_map\n#endif";

/// A call of the fragment shader: what is inserted before Bevy's function name and behind it. The
/// literals are the UV set's shader def, and the first argument, which no other call has.
macro_rules! map {
    ($uv_b:literal, $texture:literal) => {
        call(
            concat!(
                "textureSampleBias(\n#endif  // MESHLET_MESH_MATERIAL_PASS\n#ifdef BINDLESS\n",
                $texture
            ),
            concat!(
                "\n#endif  // MESHLET_MESH_MATERIAL_PASS\n#ifdef BINDLESS\n",
                $texture
            ),
            concat!(
                "#ifdef ",
                $uv_b,
                "\newa_gradient_b,\n#else\newa_gradient,\n#endif"
            ),
        )
    };
}

/// All patches.
pub fn patches() -> Vec<ShaderPatch> {
    vec![
        ShaderPatch {
            name: FRAGMENT,
            shader: ShaderName::ImportPath("bevy_pbr::pbr_fragment"),
            insertions: [
                vec![
                    Insertion::after("#define_import_path bevy_pbr::pbr_fragment", IMPORT),
                    // Before parallax, which jumps at silhouettes.
                    Insertion::before(
                        "#ifdef VERTEX_TANGENTS\n    if ((flags & pbr_types::STANDARD_MATERIAL_FLAGS_DEPTH_MAP_BIT) != 0u) {",
                        "#ifdef BEVY_EWA\n#ifdef VERTEX_UVS_A\n    let ewa_gradient = vec4(dpdx(uv), dpdy(uv));\n#endif\n    let ewa_gradient_b = vec4(dpdx(uv_b), dpdy(uv_b));\n#endif",
                    ),
                ],
                map!("STANDARD_MATERIAL_BASE_COLOR_UV_B", "                bindless_textures_2d[material_indices[slot].base_color_texture]"),
                map!("STANDARD_MATERIAL_SPECULAR_UV_B", "                bindless_textures_2d[material_indices[slot].specular_texture]"),
                map!("STANDARD_MATERIAL_SPECULAR_TINT_UV_B", "                bindless_textures_2d[material_indices[slot].specular_tint_texture]"),
                map!("STANDARD_MATERIAL_EMISSIVE_UV_B", "                    bindless_textures_2d[material_indices[slot].emissive_texture]"),
                map!("STANDARD_MATERIAL_METALLIC_ROUGHNESS_UV_B", "                    bindless_textures_2d[material_indices[slot].metallic_roughness_texture]"),
                map!("STANDARD_MATERIAL_CLEARCOAT_UV_B", "                    bindless_textures_2d[material_indices[slot].clearcoat_texture]"),
                map!("STANDARD_MATERIAL_CLEARCOAT_ROUGHNESS_UV_B", "                    bindless_textures_2d[material_indices[slot].clearcoat_roughness_texture]"),
                map!("STANDARD_MATERIAL_SPECULAR_TRANSMISSION_UV_B", "                    bindless_textures_2d[\n                        material_indices[slot].specular_transmission_texture\n"),
                map!("STANDARD_MATERIAL_THICKNESS_UV_B", "                    bindless_textures_2d[material_indices[slot].thickness_texture]"),
                map!("STANDARD_MATERIAL_DIFFUSE_TRANSMISSION_UV_B", "                    bindless_textures_2d[material_indices[slot].diffuse_transmission_texture]"),
                map!("STANDARD_MATERIAL_OCCLUSION_UV_B", "                    bindless_textures_2d[material_indices[slot].occlusion_texture]"),
                map!("STANDARD_MATERIAL_NORMAL_MAP_UV_B", "                bindless_textures_2d[material_indices[slot].normal_map_texture]"),
                map!("STANDARD_MATERIAL_CLEARCOAT_NORMAL_UV_B", "                bindless_textures_2d[material_indices[slot].clearcoat_normal_texture]"),
                map!("STANDARD_MATERIAL_ANISOTROPY_UV_B", "                    bindless_textures_2d[material_indices[slot].anisotropy_texture]"),
            ]
            .concat(),
        },
        ShaderPatch {
            name: PREPASS,
            shader: ShaderName::File("bevy_pbr/render/pbr_prepass.wgsl"),
            insertions: [
                vec![Insertion::before("#import bevy_pbr::{", IMPORT)],
                call(
                    "textureSampleBias(",
                    "\n#endif  // MESHLET_MESH_MATERIAL_PASS\n#ifdef BINDLESS\n",
                    "vec4(dpdx(uv), dpdy(uv)),",
                ),
            ]
            .concat(),
        },
        ShaderPatch {
            name: ALPHA,
            shader: ShaderName::ImportPath("bevy_pbr::pbr_prepass_functions"),
            insertions: [
                vec![Insertion::after(
                    "#define_import_path bevy_pbr::pbr_prepass_functions",
                    IMPORT,
                )],
                call(
                    "textureSampleBias(",
                    "\n#ifdef BINDLESS\n            bindless_textures_2d",
                    "vec4(dpdx(uv), dpdy(uv)),",
                ),
            ]
            .concat(),
        },
    ]
}

fn call(start: &'static str, end: &'static str, gradient: &str) -> Vec<Insertion> {
    vec![
        Insertion::before(
            start,
            format!("#ifdef BEVY_EWA\nsample_map(\n{gradient}\n#else"),
        ),
        Insertion::before(end, "#endif"),
    ]
}

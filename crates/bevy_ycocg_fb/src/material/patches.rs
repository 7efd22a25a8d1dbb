//! Inserts a call into each of Bevy's shaders that write colour to the main pass. It packs that colour
//! under the shader def `YCOCG_FB_PACK` and does nothing without it. The shader of temporal anti-aliasing rounds
//! what it writes to a target of three small floats in the same way as materials do, with dither.

use bevy_frugal_hooks::{Insertion, ShaderPatch};

/// Name of the patch of `main_pass_post_lighting_processing`, in which every lit or unlit
/// `StandardMaterial` and every other material with Bevy's lighting ends.
pub const MATERIALS: &str = "bevy_ycocg_fb/materials";

/// The patches that must be applied before any camera packs. The shaders of the other patches need not
/// be part of an app; where one of those patches is missing, its shader is detected as not packing.
pub const REQUIRED: &[&str] = &[MATERIALS];

/// Returns all patches.
pub fn patches() -> Vec<ShaderPatch> {
    let fade = "vec4(in.color.xyz, in.color.w * alpha)";
    vec![
        patch(
            MATERIALS,
            "bevy_pbr::render::pbr_functions",
            vec![
                Insertion::before(
                    "    return output_color;\n}",
                    "    output_color = pack_fragment(output_color, pbr_input.frag_coord);",
                )
                .in_function("fn main_pass_post_lighting_processing("),
            ],
        ),
        // Materials without a fragment shader of their own.
        patch(
            "bevy_ycocg_fb/unshaded",
            "bevy_pbr::render::mesh",
            [
                packed("fn fragment(", "mesh.color", "mesh.position"),
                packed(
                    "fn fragment(",
                    "vec4<f32>(1.0, 0.0, 1.0, 1.0)",
                    "mesh.position",
                ),
            ]
            .concat(),
        ),
        patch(
            "bevy_ycocg_fb/skybox",
            "bevy_core_pipeline::skybox::skybox",
            packed(
                "fn skybox_fragment(",
                "vec4(out.rgb * uniforms.brightness, out.a)",
                "in.position",
            ),
        ),
        patch(
            "bevy_ycocg_fb/taa",
            "bevy_anti_alias::taa::taa",
            packed(
                "fn taa(",
                "vec4(current_color, original_color.a)",
                "vec4(uv * texture_size, 0.0, 1.0)",
            ),
        ),
        patch(
            "bevy_ycocg_fb/gizmo_lines",
            "bevy_gizmos_render::lines",
            [
                packed("fn fragment_solid(", "in.color", "in.position"),
                packed("fn fragment_dotted(", fade, "in.position"),
                packed("fn fragment_dashed(", fade, "in.position"),
            ]
            .concat(),
        ),
        patch(
            "bevy_ycocg_fb/gizmo_joints",
            "bevy_gizmos_render::line_joints",
            [
                vec![Insertion::after(
                    "struct FragmentInput {",
                    "    @builtin(position) position: vec4<f32>,",
                )],
                packed("fn fragment(", "in.color", "in.position"),
            ]
            .concat(),
        ),
    ]
}

fn patch(name: &'static str, shader: &'static str, insertions: Vec<Insertion>) -> ShaderPatch {
    ShaderPatch {
        imports: vec!["bevy_ycocg_fb::shaders::pack::pack_fragment"],
        insertions,
        ..ShaderPatch::new(name, shader)
    }
}

/// Wraps the expression `color`, which must occur once in its function, in a call that packs it.
fn packed(function: &'static str, color: &'static str, frag_coord: &str) -> Vec<Insertion> {
    vec![
        Insertion::before(color, "pack_fragment(").in_function(function),
        Insertion::after(color, format!(", {frag_coord})")).in_function(function),
    ]
}

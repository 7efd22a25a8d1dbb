// The main pass (and the deferred prepass) of a StandardMaterial whose maps are wavelet textures.

#import bevy_pbr::{
    mesh_view_bindings::view,
    pbr_bindings,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions,
    pbr_types,
}
#import bevy_wavelet_tex::bindings

#ifdef PREPASS_PIPELINE
#import bevy_pbr::{
    prepass_io::{VertexOutput, FragmentOutput},
    pbr_deferred_functions::deferred_output,
}
#else
#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#endif

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif

    var pbr_input = pbr_input_from_standard_material(in, is_front);

#ifdef VERTEX_UVS_A
    let uv = (pbr_bindings::material.uv_transform * vec3(in.uv, 1.0)).xy;
    pbr_input.material.base_color *=
        bindings::base_color_factor(uv, in.position.xy, view.mip_bias);
    let emissive = bindings::emissive_factor(uv, in.position.xy, view.mip_bias);
    pbr_input.material.emissive =
        vec4(pbr_input.material.emissive.rgb * emissive, pbr_input.material.emissive.a);
    let roughness_metallic =
        bindings::roughness_metallic_factor(uv, in.position.xy, view.mip_bias);
    pbr_input.material.perceptual_roughness *= roughness_metallic.x;
    pbr_input.material.metallic *= roughness_metallic.y;
    // As Bevy does with screen-space occlusion: the darker of the two.
    let occlusion = bindings::occlusion(uv, in.position.xy, view.mip_bias);
    pbr_input.diffuse_occlusion = min(pbr_input.diffuse_occlusion, vec3(occlusion));

#ifdef WAVELET_NORMAL
#ifdef VERTEX_TANGENTS
    let double_sided =
        (pbr_input.material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_DOUBLE_SIDED_BIT) != 0u;
    let tangent_normal = bindings::tangent_normal(uv, in.position.xy, view.mip_bias);
    pbr_input.N = pbr_functions::apply_normal_mapping(
        // The encoder has made the map three-component and +Y up.
        0u,
        pbr_functions::calculate_tbn_mikktspace(in.world_normal, in.world_tangent),
        double_sided,
        is_front,
        0.5 + 0.5 * tangent_normal,
    );
#endif
#endif
#endif

    pbr_input.material.base_color =
        pbr_functions::alpha_discard(pbr_input.material, pbr_input.material.base_color);

#ifdef PREPASS_PIPELINE
    return deferred_output(in, pbr_input);
#else
    var out: FragmentOutput;
    if (pbr_input.material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        out.color = pbr_functions::apply_pbr_lighting(pbr_input);
    } else {
        out.color = pbr_input.material.base_color;
    }
    out.color = pbr_functions::main_pass_post_lighting_processing(pbr_input, out.color);
    return out;
#endif
}

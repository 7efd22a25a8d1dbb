// Depth, normal and motion-vector prepasses and masked shadows.

#import bevy_pbr::{
    mesh_view_bindings::view,
    pbr_bindings,
    pbr_functions,
    pbr_types,
    prepass_io,
}
#import bevy_wavelet_tex::bindings

#ifdef MOTION_VECTOR_PREPASS
#import bevy_pbr::pbr_prepass_functions
#endif

#ifdef PREPASS_FRAGMENT
@fragment
fn fragment(
    in: prepass_io::VertexOutput,
    @builtin(front_facing) is_front: bool,
) -> prepass_io::FragmentOutput {
#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    discard_transparent(in);

    var out: prepass_io::FragmentOutput;
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.frag_depth = in.unclipped_depth;
#endif
#ifdef NORMAL_PREPASS
    out.normal = vec4(0.5 + 0.5 * world_normal(in, is_front), 1.0);
#endif
#ifdef MOTION_VECTOR_PREPASS
    out.motion_vector = pbr_prepass_functions::calculate_motion_vector(
        in.world_position, in.previous_world_position,
    );
#endif
    return out;
}
#else
@fragment
fn fragment(in: prepass_io::VertexOutput) {
    discard_transparent(in);
}
#endif

// As Bevy's `prepass_alpha_discard`, with the alpha of the wavelet mask.
fn discard_transparent(in: prepass_io::VertexOutput) {
#ifdef MAY_DISCARD
    var alpha = pbr_bindings::material.base_color.a;
#ifdef VERTEX_UVS_A
    let uv = (pbr_bindings::material.uv_transform * vec3(in.uv, 1.0)).xy;
    alpha *= bindings::base_color_factor(uv, in.position.xy, view.mip_bias).a;
#endif
    let mode = pbr_bindings::material.flags
        & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    var cutoff = 0.05;
    if mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_MASK {
        cutoff = pbr_bindings::material.alpha_cutoff;
    }
    if mode != pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE && alpha < cutoff {
        discard;
    }
#endif
}

#ifdef NORMAL_PREPASS
fn world_normal(in: prepass_io::VertexOutput, is_front: bool) -> vec3<f32> {
    let double_sided = (pbr_bindings::material.flags
        & pbr_types::STANDARD_MATERIAL_FLAGS_DOUBLE_SIDED_BIT) != 0u;
#ifdef WAVELET_NORMAL
#ifdef VERTEX_TANGENTS
#ifdef VERTEX_UVS_A
    let uv = (pbr_bindings::material.uv_transform * vec3(in.uv, 1.0)).xy;
    return pbr_functions::apply_normal_mapping(
        0u,
        pbr_functions::calculate_tbn_mikktspace(in.world_normal, in.world_tangent),
        double_sided,
        is_front,
        0.5 + 0.5 * bindings::tangent_normal(uv, in.position.xy, view.mip_bias),
    );
#endif
#endif
#endif
    return normalize(pbr_functions::prepare_world_normal(in.world_normal, double_sided, is_front));
}
#endif

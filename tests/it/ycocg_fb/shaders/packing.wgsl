// A material without Bevy's lighting that packs by itself.

#import bevy_pbr::forward_io::VertexOutput
#import bevy_ycocg_fb::pack::pack_fragment

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    return pack_fragment(vec4(in.uv, 0.4, 1.0), in.position);
}

use bevy_frugal_lab::compose::Composer;

#[test]
fn elements_of_binding_arrays_are_no_arguments() {
    let with_call = |call: &str| {
        let source = format!(
            "enable wgpu_binding_array;
            @group(0) @binding(0) var textures: binding_array<texture_2d<f32>>;
            @group(0) @binding(1) var single: texture_2d<f32>;
            fn width(texture: texture_2d<f32>) -> u32 {{ return textureDimensions(texture).x; }}
            @fragment fn main(@location(0) @interpolate(flat) i: u32) -> @location(0) vec4<u32> {{
                if (i > 1u) {{ return vec4({call}); }}
                return vec4(0u);
            }}"
        );
        Composer::empty().compose_source(&source, &[])
    };
    for element in ["textures[i]", "textures[0]"] {
        let error = with_call(&format!("width({element})")).expect_err("it is refused");
        assert!(error.contains("`width`"), "{error}");
    }
    with_call("width(single)").expect("a texture is an argument");
    with_call("textureDimensions(textures[i]).x").expect("no function of the shader");
}

//! The WGSL library composes and validates without a GPU, for every filter.

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};

const DECODE: &str = include_str!("../../../crates/bevy_wavelet_tex/src/material/decode.wgsl");

/// A shader of a user's own, as the README shows it.
const USER: &str = "
#import bevy_wavelet_tex::decode

@group(0) @binding(0) var<uniform> texture: decode::WaveletTexture;
@group(0) @binding(1) var luma: texture_2d_array<f32>;
@group(0) @binding(2) var chroma: texture_2d_array<f32>;

@fragment
fn fragment(
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
) -> @location(0) vec4<f32> {
    return vec4(decode::sample(texture, luma, chroma, uv, position.xy, 0.0), 1.0);
}
";

#[test]
fn the_library_validates_in_a_shader_of_ones_own() {
    for filter in [
        None,
        Some("WAVELET_FILTER_NEAREST"),
        Some("WAVELET_FILTER_BILINEAR"),
    ] {
        let defs = || {
            filter
                .iter()
                .map(|f| (f.to_string(), ShaderDefValue::Bool(true)))
                .collect()
        };
        let mut composer = Composer::default();
        composer
            .add_composable_module(ComposableModuleDescriptor {
                source: DECODE,
                file_path: "decode.wgsl",
                ..Default::default()
            })
            .expect("the library composes");
        composer
            .make_naga_module(NagaModuleDescriptor {
                source: USER,
                file_path: "user.wgsl",
                shader_defs: defs(),
                ..Default::default()
            })
            .unwrap_or_else(|error| panic!("{filter:?}: {}", error.emit_to_string(&composer)));
    }
}

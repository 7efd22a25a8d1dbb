//! The WGSL library composes and validates without a GPU, for every filter.

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};

const LIBRARY: [(&str, &str); 4] = [
    (
        "types.wgsl",
        include_str!("../../../crates/bevy_wavelet_tex/src/material/types.wgsl"),
    ),
    (
        "decode.wgsl",
        include_str!("../../../crates/bevy_wavelet_tex/src/material/decode.wgsl"),
    ),
    (
        "sampling.wgsl",
        include_str!("../../../crates/bevy_wavelet_tex/src/material/sampling.wgsl"),
    ),
    (
        "anisotropic.wgsl",
        include_str!("../../../crates/bevy_wavelet_tex/src/material/anisotropic.wgsl"),
    ),
];

/// A shader of a user's own, as the README shows it.
const USER: &str = "
#import bevy_wavelet_tex::anisotropic::sample_anisotropic
#import bevy_wavelet_tex::sampling::sample
#import bevy_wavelet_tex::types::WaveletTexture

@group(0) @binding(0) var<uniform> texture: WaveletTexture;
@group(0) @binding(1) var luma: texture_2d_array<f32>;
@group(0) @binding(2) var detail: texture_2d_array<f32>;
@group(0) @binding(3) var chroma: texture_2d_array<f32>;
@group(0) @binding(4) var linear_clamp: sampler;
@group(0) @binding(5) var anisotropic: sampler;

@fragment
fn fragment(
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
) -> @location(0) vec4<f32> {
    return sample(texture, luma, detail, chroma, linear_clamp, uv, position.xy, 0.0)
        + sample_anisotropic(
            texture, luma, detail, chroma, linear_clamp, anisotropic, uv, position.xy, 0.0,
        );
}
";

#[test]
fn the_library_validates_in_a_shader_of_ones_own() {
    for filter in [
        None,
        Some("WAVELET_FILTER_NEAREST"),
        Some("WAVELET_FILTER_NEAREST_MIP_LINEAR"),
        Some("WAVELET_FILTER_BILINEAR"),
        Some("WAVELET_FILTER_ONE_FETCH"),
    ] {
        let defs = || {
            filter
                .iter()
                .map(|f| (f.to_string(), ShaderDefValue::Bool(true)))
                .collect()
        };
        let mut composer = Composer::default();
        for (file_path, source) in LIBRARY {
            composer
                .add_composable_module(ComposableModuleDescriptor {
                    source,
                    file_path,
                    ..Default::default()
                })
                .expect("the library composes");
        }
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

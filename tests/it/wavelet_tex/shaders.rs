//! The shader library composes and validates in a shader of a user's own, for every filter.

use bevy::shader::ShaderDefVal;
use bevy_frugal_lab::headless::HeadlessSettings;

use super::scene::app;
use crate::support::{composer, gpu};

const USER: &str = "
import bevy_wavelet_tex::material::sampling::sample;
import bevy_wavelet_tex::material::types::WaveletTexture;

@group(0) @binding(0) var<uniform> texture: WaveletTexture;
@group(0) @binding(1) var luma: texture_2d_array<f32>;
@group(0) @binding(2) var detail: texture_2d_array<f32>;
@group(0) @binding(3) var chroma: texture_2d_array<f32>;
@group(0) @binding(4) var linear_clamp: sampler;
@group(0) @binding(5) var decoded: sampler;

@fragment
fn fragment(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {
    return sample(texture, luma, detail, chroma, linear_clamp, decoded, uv, 0.0);
}
";

#[test]
fn the_library_validates_in_a_shader_of_ones_own() {
    let _gpu = gpu();
    let mut app = app(HeadlessSettings::with_size(1, 1));
    let mut composer = composer(&mut app);
    for filter in [
        None,
        Some("WAVELET_FILTER_NEAREST"),
        Some("WAVELET_FILTER_NEAREST_MIP_LINEAR"),
        Some("WAVELET_FILTER_BILINEAR"),
        Some("WAVELET_FILTER_ANISOTROPIC"),
    ] {
        let defs: Vec<ShaderDefVal> = filter.into_iter().map(ShaderDefVal::from).collect();
        let valid = composer.compose_source(USER, &defs);
        assert!(valid.is_ok(), "{filter:?}: {}", valid.unwrap_err());
    }
}

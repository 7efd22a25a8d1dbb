//! The settings, and what they mean to the plugin.

use bevy::render::renderer::RenderDevice;
use bevy_wavelet_tex::{
    WaveletFilter, WaveletStorage,
    codec::{rate::Rate, settings::Effort},
    material::storage_on,
};

use crate::{
    runner::{SceneSetting, SceneSettings},
    scenes::error_view,
};

/// What there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Room,
    Rates,
}

pub fn all() -> Vec<SceneSetting> {
    vec![
        SceneSetting::choice(
            "place",
            "the lit room, or the picture at all rates side by side",
            0,
            &["room", "rates"],
        ),
        error_view::view_setting(),
        error_view::gain_setting(),
        SceneSetting::float(
            "zoom",
            "of rates: the part of the picture that is shown, magnified so often",
            1.0,
            1.0..=32.0,
            "",
        ),
        SceneSetting::float(
            "focus_x",
            "of rates: the middle of that part, from the left edge to the right one",
            0.5,
            0.0..=1.0,
            "",
        ),
        SceneSetting::float(
            "focus_y",
            "the same from the upper edge to the lower one",
            0.5,
            0.0..=1.0,
            "",
        ),
        SceneSetting::choice(
            "filter",
            "how decoded pixels are filtered",
            5,
            &[
                "nearest",
                "nearest_mip_linear",
                "stochastic",
                "stochastic_quad",
                "bilinear",
                "trilinear",
                "anisotropic",
            ],
        ),
        SceneSetting::choice(
            "color_rate",
            "of the room: bits per pixel of colours",
            1,
            &["color2.25", "color3", "color3.25", "color5"],
        ),
        SceneSetting::choice(
            "effort",
            "how hard the encoder searches",
            1,
            &["fast", "default", "best"],
        ),
        SceneSetting::choice(
            "storage",
            "as BC blocks, or decoded on load as without BC",
            0,
            &["blocks", "decoded"],
        ),
        SceneSetting::float(
            "light_angle",
            "of the room: direction of the light",
            25.0,
            -80.0..=80.0,
            "degrees",
        ),
    ]
}

pub fn place(settings: &SceneSettings) -> Place {
    match settings.choice("place") {
        "rates" => Place::Rates,
        _ => Place::Room,
    }
}

pub fn filter(settings: &SceneSettings) -> WaveletFilter {
    match settings.choice("filter") {
        "nearest" => WaveletFilter::Nearest,
        "nearest_mip_linear" => WaveletFilter::NearestMipLinear,
        "stochastic" => WaveletFilter::Stochastic,
        "stochastic_quad" => WaveletFilter::StochasticQuad,
        "anisotropic" => WaveletFilter::Anisotropic,
        "bilinear" => WaveletFilter::Bilinear,
        _ => WaveletFilter::Trilinear,
    }
}

pub fn effort(settings: &SceneSettings) -> Effort {
    match settings.choice("effort") {
        "fast" => Effort::Fast,
        "best" => Effort::Best,
        _ => Effort::Default,
    }
}

pub fn storage(settings: &SceneSettings, device: &RenderDevice) -> WaveletStorage {
    match settings.choice("storage") {
        "decoded" => WaveletStorage::Decoded,
        _ => storage_on(device),
    }
}

pub fn color_rate(settings: &SceneSettings) -> Rate {
    Rate::from_name(settings.choice("color_rate")).unwrap_or(Rate::Color3)
}

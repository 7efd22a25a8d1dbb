//! The knobs, and what they mean to the plugin.

use bevy_wavelet_tex::{
    WaveletFilter, WaveletStorage,
    codec::{rate::Rate, settings::Effort},
};

use crate::{
    runner::{Knob, Knobs},
    scenes::error_view,
};

/// What there is to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The room.
    Room,
    /// The picture at all rates.
    Rates,
}

/// All of them.
pub fn all() -> Vec<Knob> {
    vec![
        Knob::choice(
            "place",
            "the lit room, or the picture at all rates side by side",
            0,
            &["room", "rates"],
        ),
        error_view::view_knob(),
        error_view::gain_knob(),
        Knob::float(
            "zoom",
            "of rates: the part of the picture that is shown, magnified so often",
            1.0,
            1.0..=32.0,
            "",
        ),
        Knob::float(
            "focus_x",
            "of rates: the middle of that part, from the left edge to the right one",
            0.5,
            0.0..=1.0,
            "",
        ),
        Knob::float(
            "focus_y",
            "the same from the upper edge to the lower one",
            0.5,
            0.0..=1.0,
            "",
        ),
        Knob::choice(
            "filter",
            "how decoded pixels are filtered",
            4,
            &[
                "nearest",
                "nearest_mip_linear",
                "bilinear",
                "one_fetch_trilinear",
                "trilinear",
                "anisotropic",
            ],
        ),
        Knob::choice(
            "color_rate",
            "of the room: bits per pixel of colours",
            1,
            &["color2.25", "color3", "color3.25", "color5"],
        ),
        Knob::choice(
            "effort",
            "how hard the encoder searches",
            1,
            &["fast", "default", "best"],
        ),
        Knob::choice(
            "storage",
            "as BC blocks, or decoded on load as without BC",
            0,
            &["blocks", "decoded"],
        ),
        Knob::float(
            "light_angle",
            "of the room: direction of the lamp",
            25.0,
            -80.0..=80.0,
            "degrees",
        ),
    ]
}

/// What is shown.
pub fn place(knobs: &Knobs) -> Place {
    match knobs.choice("place") {
        "rates" => Place::Rates,
        _ => Place::Room,
    }
}

/// The filter of all wavelet textures.
pub fn filter(knobs: &Knobs) -> WaveletFilter {
    match knobs.choice("filter") {
        "nearest" => WaveletFilter::Nearest,
        "nearest_mip_linear" => WaveletFilter::NearestMipLinear,
        "one_fetch_trilinear" => WaveletFilter::OneFetchTrilinear,
        "anisotropic" => WaveletFilter::Anisotropic,
        "bilinear" => WaveletFilter::Bilinear,
        _ => WaveletFilter::Trilinear,
    }
}

/// The encoder's effort.
pub fn effort(knobs: &Knobs) -> Effort {
    match knobs.choice("effort") {
        "fast" => Effort::Fast,
        "best" => Effort::Best,
        _ => Effort::Default,
    }
}

/// How textures are kept.
pub fn storage(knobs: &Knobs) -> WaveletStorage {
    match knobs.choice("storage") {
        "decoded" => WaveletStorage::Decoded,
        _ => WaveletStorage::Blocks,
    }
}

/// The rate of the room's colours.
pub fn color_rate(knobs: &Knobs) -> Rate {
    Rate::from_name(knobs.choice("color_rate")).unwrap_or(Rate::Color3)
}

//! How the colours of a camera come to the display.

use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};

/// As of every camera of Bevy.
pub const TONE_MAPPED: (Tonemapping, DebandDither) =
    (Tonemapping::TonyMcMapface, DebandDither::Enabled);

/// As they are. Without tone mapping Bevy does not dither, and warns of cameras that ask for it.
pub const UNGRADED: (Tonemapping, DebandDither) = (Tonemapping::None, DebandDither::Disabled);

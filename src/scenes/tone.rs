//! How the colours of a camera are mapped to the display.

use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};

/// Bevy's default for a `Camera3d`: it tone-maps and dithers.
pub const TONE_MAPPED: (Tonemapping, DebandDither) =
    (Tonemapping::TonyMcMapface, DebandDither::Enabled);

/// The camera writes its colours unchanged. Bevy does not dither without tone mapping, and warns of cameras
/// that ask for it.
pub const UNGRADED: (Tonemapping, DebandDither) = (Tonemapping::None, DebandDither::Disabled);

//! Pictures in floats, and what a volume adds to them.

use bevy::prelude::*;

use crate::headless::{HeadlessApp, HeadlessError};

/// The picture of the next frame.
pub(super) fn picture(app: &mut HeadlessApp) -> Result<Vec<Vec3>, HeadlessError> {
    let image = app.capture_f32()?;
    let rgb = |p: &[f32; 4]| Vec3::new(p[0], p[1], p[2]);
    Ok(image.pixels.iter().map(rgb).collect())
}

/// One picture less another.
pub(super) fn difference(with: &[Vec3], without: &[Vec3]) -> Vec<Vec3> {
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

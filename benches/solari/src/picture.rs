//! Pictures in floats.

use bevy::math::Vec3;
use bevy_frugal_lab::headless::{HeadlessApp, HeadlessError};

/// The picture of the last frame.
pub fn picture(app: &mut HeadlessApp) -> Result<Vec<Vec3>, HeadlessError> {
    let image = app.capture_f32()?;
    let rgb = |p: &[f32; 4]| Vec3::new(p[0], p[1], p[2]);
    Ok(image.pixels.iter().map(rgb).collect())
}

/// One picture less another.
pub fn difference(with: &[Vec3], without: &[Vec3]) -> Vec<Vec3> {
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

/// Mean absolute difference of two pictures over the mean of the second.
pub fn flicker(before: &[Vec3], now: &[Vec3]) -> f64 {
    let sum = |values: &mut dyn Iterator<Item = Vec3>| -> f64 {
        values.map(|v| f64::from(v.element_sum())).sum()
    };
    sum(&mut before.iter().zip(now).map(|(a, b)| (b - a).abs())) / sum(&mut now.iter().copied())
}

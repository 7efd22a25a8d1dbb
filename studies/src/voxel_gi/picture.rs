//! Pictures in floats, and what a volume adds to them.

use bevy::prelude::*;

use bevy_frugal_lab::headless::{HeadlessApp, HeadlessError};

/// The picture of the last frame.
pub(super) fn picture(app: &mut HeadlessApp) -> Result<Vec<Vec3>, HeadlessError> {
    let image = app.capture_f32()?;
    let rgb = |p: &[f32; 4]| Vec3::new(p[0], p[1], p[2]);
    Ok(image.pixels.iter().map(rgb).collect())
}

/// One picture less another.
pub(super) fn difference(with: &[Vec3], without: &[Vec3]) -> Vec<Vec3> {
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

/// Means of 2 x 2 pixels of a picture of this width.
pub(super) fn halved(picture: &[Vec3], width: u32) -> Vec<Vec3> {
    let width = width as usize;
    let rows = picture.chunks_exact(2 * width);
    rows.flat_map(|rows| {
        let pixel = move |x: usize| rows[x] + rows[x + 1] + rows[x + width] + rows[x + width + 1];
        (0..width / 2).map(move |x| 0.25 * pixel(2 * x))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_of_a_halved_picture_are_means() {
        let picture: Vec<_> = (0..16).map(|i| Vec3::splat(i as f32)).collect();
        let halved = halved(&picture, 4);
        assert_eq!(halved, [2.5, 4.5, 10.5, 12.5].map(Vec3::splat));
    }
}

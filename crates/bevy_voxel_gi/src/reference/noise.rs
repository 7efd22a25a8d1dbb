//! Noise of light on flat walls: how far the light of a point is from its smooth neighbourhood.

use super::rays::tangents;
use glam::{Vec2, Vec3};

/// The light at a point of a flat wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallSample {
    /// The wall: samples of other walls are no neighbours.
    pub wall: u32,
    /// Position in metres.
    pub position: Vec3,
    /// Normal of the wall, a unit vector.
    pub normal: Vec3,
    /// The light, in any unit.
    pub light: f32,
}

/// Number of coefficients of a quadratic polynomial of two variables.
const TERMS: usize = 6;

/// A neighbourhood is complete if its centroid is no farther than this from its centre, in radii.
const OFF_CENTER: f32 = 0.1;

/// A neighbourhood has at least this number of samples, three for each coefficient.
const MIN_SAMPLES: usize = 3 * TERMS;

/// Returns the noise: root mean square of the deviation from the quadratic polynomial that fits the samples
/// of the same wall within `radius` metres best, relative to the mean of the light; `None` if no sample has
/// a complete neighbourhood.
///
/// Samples near the border of a wall, or of what hides it, have no complete neighbourhood and do not count.
pub fn wall_noise(samples: &[WallSample], radius: f32) -> Option<f32> {
    let mut walls: Vec<u32> = samples.iter().map(|sample| sample.wall).collect();
    walls.sort_unstable();
    walls.dedup();
    let (mut squares, mut light, mut count) = (0.0, 0.0, 0.0);
    for wall in walls {
        let on_wall: Vec<_> = samples.iter().filter(|s| s.wall == wall).collect();
        let (t, b) = tangents(on_wall[0].normal);
        let flat: Vec<(Vec2, f32)> = on_wall
            .iter()
            .map(|s| (Vec2::new(t.dot(s.position), b.dot(s.position)), s.light))
            .collect();
        for &(center, value) in &flat {
            if let Some(smooth) = smooth_light(&flat, center, radius) {
                squares += f64::from(value - smooth).powi(2);
                light += f64::from(value);
                count += 1.0;
            }
        }
    }
    (count > 0.0 && light > 0.0).then(|| ((squares / count).sqrt() * count / light) as f32)
}

/// The value at `center` of the quadratic polynomial that fits the samples around it best.
fn smooth_light(samples: &[(Vec2, f32)], center: Vec2, radius: f32) -> Option<f32> {
    let near = samples
        .iter()
        .map(|(position, light)| ((*position - center) / radius, *light))
        .filter(|(offset, _)| offset.length_squared() < 1.0);
    let mut normal = [[0.0; TERMS + 1]; TERMS];
    let (mut centroid, mut count) = (Vec2::ZERO, 0);
    for (offset, light) in near {
        let (x, y) = (f64::from(offset.x), f64::from(offset.y));
        let terms = [1.0, x, y, x * x, x * y, y * y];
        for (row, term) in normal.iter_mut().zip(terms) {
            for (cell, other) in row.iter_mut().zip(terms) {
                *cell += term * other;
            }
            row[TERMS] += term * f64::from(light);
        }
        centroid += offset;
        count += 1;
    }
    let is_complete = centroid.length() <= OFF_CENTER * count as f32;
    if count < MIN_SAMPLES || !is_complete {
        return None;
    }
    first_unknown(normal)
}

/// The first unknown of a positive definite system of linear equations, by elimination from the last one.
fn first_unknown(mut rows: [[f64; TERMS + 1]; TERMS]) -> Option<f32> {
    for pivot in (0..TERMS).rev() {
        let row = rows[pivot];
        if row[pivot] < 1e-9 {
            return None;
        }
        for other in &mut rows[..pivot] {
            let factor = other[pivot] / row[pivot];
            for (cell, value) in other.iter_mut().zip(row) {
                *cell -= factor * value;
            }
        }
    }
    Some((rows[0][TERMS] / rows[0][0]) as f32)
}

//! Normals in pixels of 8 bits, and the angles between them, which measure the error of normal maps.

use glam::DVec3;
use serde::Serialize;

/// Angles between the normals of two maps, in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Angles {
    /// The mean angle.
    pub mean_angle_degrees: f64,
    /// The 99th percentile: 99 of 100 pixels have at most this angle.
    pub p99_angle_degrees: f64,
    /// The largest angle.
    pub max_angle_degrees: f64,
}

impl Angles {
    /// Computes the angles of pairs of unit vectors, of which there is at least one.
    pub fn between(pairs: impl Iterator<Item = ([f64; 3], [f64; 3])>) -> Self {
        let mut angles: Vec<f64> = pairs.map(|(a, b)| angle(a, b).to_degrees()).collect();
        angles.sort_unstable_by(f64::total_cmp);
        let last = angles.len() - 1;
        Self {
            mean_angle_degrees: angles.iter().sum::<f64>() / angles.len() as f64,
            p99_angle_degrees: angles[last * 99 / 100],
            max_angle_degrees: angles[last],
        }
    }
}

/// The normal that a pixel of 8 bits stands for.
pub fn unit_of([x, y, z, _]: [u8; 4]) -> [f64; 3] {
    unit([x, y, z].map(|v| f64::from(v) / 127.5 - 1.0))
}

/// The blue of a pixel of 8 bits whose normal has this red and green: the Z of the unit vector.
pub fn normal_blue(red_green: [u8; 2]) -> u8 {
    let [x, y] = red_green.map(|v| f64::from(v) / 127.5 - 1.0);
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    (z * 127.5 + 127.5).round() as u8
}

/// Normalises a vector. The zero vector has no direction and becomes +Z.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let v = DVec3::from(v);
    if v.length() > 1e-6 {
        v.normalize().to_array()
    } else {
        DVec3::Z.to_array()
    }
}

/// Angle between unit vectors, in radians. It is accurate for small angles, unlike the arc cosine.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (DVec3::from(a), DVec3::from(b));
    2.0 * (a - b).length().atan2((a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_trigonometry() {
        for degrees in [1e-6, 0.1, 45.0, 90.0, 179.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let found = angle([0.0, 0.0, 1.0], [sin, 0.0, cos]).to_degrees();
            assert!(
                (found - degrees).abs() < 1e-9 * degrees.max(1.0),
                "{found} {degrees}"
            );
        }
        assert_eq!(unit_of([0, 0, 0, 255])[2], unit([-1.0; 3])[2]);
        assert_eq!(unit([0.0; 3]), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn one_pixel_of_a_hundred_is_beyond_the_percentile() {
        let up = [0.0, 0.0, 1.0];
        let pairs = (0..200).map(|i| (up, if i < 2 { [1.0, 0.0, 0.0] } else { up }));
        let angles = Angles::between(pairs);
        assert_eq!(angles.p99_angle_degrees, 0.0);
        assert!((angles.max_angle_degrees - 90.0).abs() < 1e-9);
        assert!((angles.mean_angle_degrees - 0.9).abs() < 1e-9);
    }
}

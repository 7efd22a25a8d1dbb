//! Noise of a picture on the flat walls of a scene.

use bevy::math::Vec3;
use bevy_voxel_gi::reference::noise::{WallSample, wall_noise};

use super::{BoxScene, walls::visible_walls};

/// The smooth neighbourhood of a pixel is within this many voxels of the volume.
const RADIUS: f32 = 3.0;

/// Returns the noise of the light on the walls that the scene's camera sees: root mean square of a pixel's
/// deviation from its smooth neighbourhood, relative to the mean; `None` if no wall is large enough.
///
/// The picture is radiance, of which each wall has one albedo; `resolution` is that of the volume.
pub fn picture_noise(picture: &[Vec3], scene: &BoxScene, resolution: u32) -> Option<f64> {
    let (_, size) = scene.volume(resolution);
    let walls = visible_walls(scene).into_iter().zip(picture);
    let samples: Vec<_> = walls
        .filter_map(|(point, radiance)| {
            let point = point?;
            let albedo = point.albedo.element_sum();
            (albedo > 0.0).then(|| WallSample {
                wall: point.wall,
                position: point.position,
                normal: point.normal,
                light: radiance.element_sum() / albedo,
            })
        })
        .collect();
    wall_noise(&samples, RADIUS * size / resolution as f32).map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes::cornell_box;

    /// A picture of the box's albedo under light of this irradiance over pi.
    fn lit(light: impl Fn(usize, Vec3) -> f32) -> Vec<Vec3> {
        let points = visible_walls(&cornell_box()).into_iter().enumerate();
        points
            .map(|(i, point)| point.map_or(Vec3::ZERO, |p| p.albedo * light(i, p.position)))
            .collect()
    }

    #[test]
    fn light_that_changes_evenly_has_no_noise() {
        let picture = lit(|_, p| 3.0 + p.x + 0.5 * p.y * p.y + 0.3 * p.z * p.x);
        let noise = picture_noise(&picture, &cornell_box(), 32).expect("walls");
        assert!(noise < 1e-4, "{noise}");
    }

    #[test]
    fn a_checkerboard_has_the_noise_of_its_contrast() {
        let picture = lit(|i, _| {
            1.0 + if (i + i / 128).is_multiple_of(2) {
                0.02
            } else {
                -0.02
            }
        });
        let noise = picture_noise(&picture, &cornell_box(), 32).expect("walls");
        assert!((noise - 0.02).abs() < 1e-3, "{noise}");
    }
}

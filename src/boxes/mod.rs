//! Scenes of boxes and lights in plain numbers, of which path-traced light is known.
//!
//! Metres, right-handed, Y up; light per channel.

use std::{
    error::Error,
    fmt, fs,
    path::{Path, PathBuf},
};

use bevy::math::{DVec3, Quat, Vec3};
use bevy_voxel_gi::reference::noise::{WallSample, wall_noise};
use serde::Deserialize;

use crate::{
    path_tracer::Gloss,
    stage::{SceneCamera, SceneDirectionalLight, ScenePointLight, Stage, volume_around},
};

pub use crate::boxes::solids::{
    spawn_box_scene, spawn_boxes_and_lights, trace, trace_receivers, visible_walls,
};

mod solids;
#[cfg(test)]
mod tests;

/// A scene whose light an independent renderer has path-traced.
pub struct TracedScene {
    /// The geometry, the lights and the camera.
    pub scene: BoxScene,
    /// Block means of the radiance that the lights cause directly.
    pub direct: Vec<Vec3>,
    /// Block means of all other radiance of surfaces, the sky's first arrival included.
    pub indirect: Vec<Vec3>,
}

impl TracedScene {
    /// Names of all traced scenes.
    pub const NAMES: [&str; 3] = ["cornell_point", "colonnade", "sunlit_room"];

    /// Reads a scene from `crates/bevy_voxel_gi/tests/data`, whose README describes the files.
    pub fn read(name: &str) -> Result<Self, TruthError> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/bevy_voxel_gi/tests/data");
        let truth = |part| read_npy(&folder.join(format!("{name}.{part}.npy")));
        Ok(Self {
            scene: BoxScene::read(&folder.join(format!("{name}.json")))?,
            direct: truth("direct")?,
            indirect: truth("indirect")?,
        })
    }
}

/// The Cornell box, 2 m wide, open in front, with a point light of 10 cd under its ceiling.
pub fn cornell_box() -> BoxScene {
    serde_json::from_str(include_str!(
        "../../crates/bevy_voxel_gi/tests/data/cornell_point.json"
    ))
    .expect("a scene, as its tests show")
}

/// A scene of boxes.
#[derive(Clone, Debug, Deserialize)]
pub struct BoxScene {
    /// The scene's name.
    pub name: String,
    /// The boxes of the scene.
    pub boxes: Vec<SceneBox>,
    /// Lights without size.
    #[serde(default)]
    pub point_lights: Vec<ScenePointLight>,
    /// Lights that are infinitely far away.
    #[serde(default)]
    pub directional_lights: Vec<SceneDirectionalLight>,
    /// Radiance of the sky, in candela per square metre.
    #[serde(default)]
    pub sky_radiance: Vec3,
    /// What the quarter of the sky at +X and +Z has beyond that.
    #[serde(default)]
    pub sky_quarter: Vec3,
    /// The camera of the truth.
    pub camera: SceneCamera,
}

/// A box, Lambertian unless it has gloss.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct SceneBox {
    /// The centre of the box in metres.
    pub center: Vec3,
    /// Half of the lengths of its edges in metres.
    pub half: Vec3,
    /// The diffuse albedo per channel, 0 to 1.
    pub albedo: Vec3,
    /// The rotation about Y in degrees, counter-clockwise seen from above. Default 0.
    #[serde(default)]
    pub rotate_y_deg: f32,
    /// Its gloss. Default none.
    #[serde(default)]
    pub gloss: Option<BoxGloss>,
}

/// The gloss of a box, in the terms of `StandardMaterial`.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct BoxGloss {
    /// The perceptual roughness, 0.089 to 1.
    pub roughness: f32,
    /// The specular reflectance of what is no metal, 0.36 to 1.
    pub reflectance: f32,
    /// Whether it is a metal, which reflects its albedo without diffuse light.
    pub is_metal: bool,
}

impl SceneBox {
    /// The rotation about Y.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.rotate_y_deg.to_radians())
    }
}

impl BoxGloss {
    /// The specular lobe of a box of this albedo.
    pub fn lobe(&self, albedo: Vec3) -> Gloss {
        Gloss {
            roughness: self.roughness,
            f0: if self.is_metal {
                albedo
            } else {
                Vec3::splat(0.16 * self.reflectance.powi(2))
            },
        }
    }
}

impl BoxScene {
    fn read(path: &Path) -> Result<Self, TruthError> {
        let wrong = |error: &dyn std::fmt::Display| TruthError {
            path: path.to_owned(),
            error: error.to_string(),
        };
        let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
        serde_json::from_str(&text).map_err(|error| wrong(&error))
    }

    /// Its lights, sky and camera.
    pub fn stage(&self) -> Stage {
        Stage {
            point_lights: self.point_lights.clone(),
            directional_lights: self.directional_lights.clone(),
            sky_radiance: self.sky_radiance,
            sky_quarter: self.sky_quarter,
            camera: self.camera,
        }
    }

    /// Corners of the bounds of all boxes.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in &self.boxes {
            for corner in 0..8 {
                let sign = Vec3::new(
                    if corner & 1 == 0 { -1.0 } else { 1.0 },
                    if corner & 2 == 0 { -1.0 } else { 1.0 },
                    if corner & 4 == 0 { -1.0 } else { 1.0 },
                );
                let at = part.center + part.rotation() * (part.half * sign);
                bounds = (bounds.0.min(at), bounds.1.max(at));
            }
        }
        bounds
    }

    /// Centre and edge of the smallest volume of this many voxels along an edge that leaves one
    /// free on each side.
    pub fn volume(&self, resolution: u32) -> (Vec3, f32) {
        volume_around(self.bounds(), resolution)
    }
}

/// A file that is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TruthError {
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub error: String,
}

impl fmt::Display for TruthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.error)
    }
}

impl Error for TruthError {}

/// Reads an H x W x 3 array of little-endian 32-bit floats in NumPy's format, version 1.
pub fn read_npy(path: &Path) -> Result<Vec<Vec3>, TruthError> {
    let wrong = |error: &str| TruthError {
        path: path.to_owned(),
        error: error.to_owned(),
    };
    let bytes = fs::read(path).map_err(|error| wrong(&error.to_string()))?;
    parse_npy(&bytes).map_err(wrong)
}

fn parse_npy(bytes: &[u8]) -> Result<Vec<Vec3>, &'static str> {
    let (header, data) = bytes
        .strip_prefix(b"\x93NUMPY\x01\x00")
        .and_then(|rest| rest.split_first_chunk::<2>())
        .and_then(|(length, rest)| rest.split_at_checked(u16::from_le_bytes(*length).into()))
        .ok_or("not a NumPy file of version 1")?;
    let header = String::from_utf8_lossy(header);
    if !header.contains("'<f4'") || !header.contains("'fortran_order': False") {
        return Err("not little-endian 32-bit floats in C order");
    }
    let floats: Vec<f32> = data
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    Ok(floats.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// Edge in pixels of the blocks whose means are compared: single pixels of a path-traced picture are noisy.
const BLOCK: usize = 4;

/// Indices of the pixels of each whole block, row after row.
fn blocks(width: u32, pixels: usize) -> impl Iterator<Item = [usize; BLOCK * BLOCK]> {
    let width = width as usize;
    let (columns, rows) = (width / BLOCK, pixels / width.max(1) / BLOCK);
    (0..rows * columns).map(move |block| {
        let corner = block / columns * BLOCK * width + block % columns * BLOCK;
        std::array::from_fn(|i| corner + i / BLOCK * width + i % BLOCK)
    })
}

fn mean(picture: &[Vec3], block: &[usize]) -> Vec3 {
    let sum: DVec3 = block.iter().map(|&i| picture[i].as_dvec3()).sum();
    (sum / block.len() as f64).as_vec3()
}

/// Means of 4 x 4 pixels; zero where one of the 16 sees no surface, and so is zero.
pub fn block_means(picture: &[Vec3], width: u32) -> Vec<Vec3> {
    blocks(width, picture.len())
        .map(|block| {
            if block.iter().any(|&i| picture[i] == Vec3::ZERO) {
                Vec3::ZERO
            } else {
                mean(picture, &block)
            }
        })
        .collect()
}

/// How close a picture comes to the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Mean absolute difference over mean truth.
    pub relative_error: f64,
    /// Mean difference over mean truth.
    pub bias: f64,
    /// The 95th percentile of the relative error of blocks: of the absolute difference over the block's truth, or over
    /// a tenth of the mean truth where that is more.
    pub percentile_95: f64,
    /// The share of black blocks: of those below 1% of the mean truth whose truth is above it.
    pub black: f64,
}

/// Compares the picture with the block means of the truth, where those are not zero.
///
/// # Panics
/// If the picture has another number of blocks than the truth.
pub fn agreement(picture: &[Vec3], width: u32, truth: &[Vec3]) -> Agreement {
    let blocks: Vec<_> = blocks(width, picture.len()).collect();
    assert_eq!(blocks.len(), truth.len(), "pictures of two sizes");
    let compared = blocks.iter().zip(truth);
    let compared = compared.filter(|(_, truth)| **truth != Vec3::ZERO);
    let compared: Vec<_> = compared
        .map(|(block, truth)| (mean(picture, block).as_dvec3(), truth.as_dvec3()))
        .collect();
    let count = compared.len() as f64;
    let mean_of = |value: &dyn Fn(&(DVec3, DVec3)) -> f64| {
        compared.iter().map(value).sum::<f64>() / count.max(1.0)
    };
    let reference = mean_of(&|(_, truth)| truth.element_sum());
    let absolute = |(found, truth): &(DVec3, DVec3)| (found - truth).abs().element_sum();
    let relative =
        |block: &(DVec3, DVec3)| absolute(block) / block.1.element_sum().max(0.1 * reference);
    let mut errors: Vec<_> = compared.iter().map(relative).collect();
    errors.sort_by(f64::total_cmp);
    let is_black = |(found, truth): &(DVec3, DVec3)| {
        let least = 0.01 * reference;
        f64::from(found.element_sum() < least && truth.element_sum() > least)
    };
    Agreement {
        relative_error: mean_of(&absolute) / reference,
        bias: mean_of(&|(found, truth)| (found - truth).element_sum()) / reference,
        percentile_95: errors.get(errors.len() * 19 / 20).copied().unwrap_or(0.0),
        black: mean_of(&is_black),
    }
}

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
mod array_tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn arrays_come_back_and_damaged_ones_never_panic(
            floats in prop::collection::vec(any::<f32>(), 0..30),
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
            cut in any::<prop::sample::Index>(),
        ) {
            let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 3), }\n";
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((header.len() as u16).to_le_bytes());
            bytes.extend(header.bytes());
            bytes.extend(floats.iter().flat_map(|f| f.to_le_bytes()));
            let back = parse_npy(&bytes).expect("a good file");
            let back: Vec<u32> = back.iter().flat_map(|v| v.to_array()).map(f32::to_bits).collect();
            let expected: Vec<u32> = floats.iter().map(|f| f.to_bits()).collect();
            prop_assert_eq!(&back, &expected[..floats.len() / 3 * 3]);
            for (at, value) in damage {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            let _ = parse_npy(&bytes[..cut.index(bytes.len() + 1)]);
        }
    }

    #[test]
    fn a_tenth_too_bright() {
        let truth: Vec<Vec3> = (0..64).map(|i| Vec3::splat(1.0 + i as f32)).collect();
        let picture: Vec<Vec3> = truth.iter().map(|t| t * 1.1).collect();
        let found = agreement(&picture, 8, &block_means(&truth, 8));
        assert!((found.relative_error - 0.1).abs() < 1e-6);
        assert!((found.bias - 0.1).abs() < 1e-6);
        assert!((found.percentile_95 - 0.1).abs() < 1e-6);
        assert_eq!(found.black, 0.0);
    }

    #[test]
    fn a_quarter_that_is_black() {
        let truth = vec![Vec3::ONE; 64];
        let mut picture = truth.clone();
        for row in picture.chunks_exact_mut(8).take(4) {
            row[..4].fill(Vec3::ZERO);
        }
        let found = agreement(&picture, 8, &block_means(&truth, 8));
        let expected = Agreement {
            relative_error: 0.25,
            bias: -0.25,
            percentile_95: 1.0,
            black: 0.25,
        };
        assert_eq!(found, expected);
    }

    #[test]
    fn blocks_that_see_nothing_do_not_count() {
        let mut truth = vec![Vec3::ONE; 32];
        let mut picture = truth.clone();
        truth[0] = Vec3::ZERO;
        picture[1] = Vec3::splat(100.0);
        let truth = block_means(&truth, 8);
        assert_eq!(agreement(&picture, 8, &truth), Agreement::default());
    }
}

#[cfg(test)]
mod noise_tests {
    use super::*;

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

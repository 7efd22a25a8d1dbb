//! Scenes of boxes and lights in plain numbers, of which path-traced light is known.
//!
//! Metres, right-handed, Y up; light per channel.

mod noise;
mod solids;
mod spawn;
#[cfg(test)]
mod tests;
mod truth;
mod walls;

use std::path::Path;

use bevy::math::{Quat, Vec3};
use serde::Deserialize;

use crate::stage::{SceneCamera, SceneDirectionalLight, ScenePointLight, Stage, volume_around};

pub use noise::picture_noise;
pub use solids::{trace, trace_receivers};
pub use spawn::{spawn_box_scene, spawn_boxes_and_lights};
pub use truth::{Agreement, TruthError, agreement, block_means, read_npy};

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
    ///
    /// # Errors
    /// [`TruthError`] names the file and what is wrong with it.
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
    /// The camera of the truth.
    pub camera: SceneCamera,
}

/// A Lambertian box.
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
}

impl SceneBox {
    /// The rotation about Y.
    pub fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.rotate_y_deg.to_radians())
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

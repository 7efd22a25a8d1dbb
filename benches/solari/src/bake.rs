//! The memory and the time that a bake takes.

use std::time::{Duration, Instant};

use bevy::image::Image;
use bevy_frugal_studies::{record::Times, voxel_gi::LightRow};

/// The cost of a baked texture.
#[derive(Clone, Copy, Debug)]
pub struct Baked {
    /// Size of the texture in bytes.
    pub bytes: u64,
    /// Time on the clock, with all cores at work.
    pub time: Duration,
}

impl Baked {
    /// Bakes a texture.
    pub fn bake(texture: impl FnOnce() -> Image) -> (Self, Image) {
        let start = Instant::now();
        let image = texture();
        let baked = Self {
            bytes: image.data.as_ref().map_or(0, Vec::len) as u64,
            time: start.elapsed(),
        };
        (baked, image)
    }

    /// The row of a method's bake.
    pub fn row(self, scene: &str, method: &str) -> LightRow {
        LightRow {
            scene: scene.into(),
            setting: format!("{method}, bake"),
            bytes: Some(self.bytes),
            times: Times {
                cpu_ms: Some(1e3 * self.time.as_secs_f64()),
                ..Times::default()
            },
            ..LightRow::default()
        }
    }
}

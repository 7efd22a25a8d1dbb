//! What bakes share: their memory and time, light for texels and voxels that boxes cover, and textures of light.

use std::time::{Duration, Instant};

use bevy::{
    asset::RenderAssetUsages,
    image::{Image, ImageSampler},
    math::{UVec3, Vec3},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_frugal_studies::{record::Times, voxel_gi::LightRow};
use half::f16;

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

/// Gives each place without light the mean of the places around it that have some, those next to them first; places
/// are in rows of X, then Y, then Z.
pub fn fill(light: &mut [Option<Vec3>], size: UVec3) {
    loop {
        let before = light.to_vec();
        let mut is_changed = false;
        for (index, place) in light.iter_mut().enumerate() {
            if place.is_none() {
                *place = mean_around(&before, size, index as u32);
                is_changed |= place.is_some();
            }
        }
        if !is_changed {
            return;
        }
    }
}

fn mean_around(light: &[Option<Vec3>], size: UVec3, index: u32) -> Option<Vec3> {
    let at = UVec3::new(index, index / size.x, index / (size.x * size.y)) % size;
    let low = at.saturating_sub(UVec3::ONE);
    let high = (at + 1).min(size - 1);
    let (mut sum, mut count) = (Vec3::ZERO, 0);
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                if let Some(found) = light[(x + size.x * (y + size.y * z)) as usize] {
                    sum += found;
                    count += 1;
                }
            }
        }
    }
    (count > 0).then(|| sum / count as f32)
}

/// A texture of 16-bit floats that is interpolated, from texels in rows of X, then Y, then Z.
pub fn texture(dimension: TextureDimension, size: UVec3, texels: &[Vec3]) -> Image {
    let halves = texels
        .iter()
        .flat_map(|light| light.extend(1.0).to_array().map(f16::from_f32));
    let mut image = Image::new(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: size.z,
        },
        dimension,
        halves.flat_map(f16::to_le_bytes).collect(),
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    // It clamps to the edges.
    image.sampler = ImageSampler::linear();
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_without_light_get_that_of_the_next() {
        let size = UVec3::new(4, 2, 3);
        let mut light = vec![None; 24];
        light[0] = Some(Vec3::ONE);
        fill(&mut light, size);
        assert!(light.iter().all(|place| *place == Some(Vec3::ONE)));

        let mut light = vec![Some(Vec3::ZERO), None, Some(Vec3::splat(2.0)), None];
        fill(&mut light, UVec3::new(4, 1, 1));
        assert_eq!(light[1], Some(Vec3::ONE));
        assert_eq!(light[3], Some(Vec3::splat(2.0)));
    }

    #[test]
    fn without_any_light_all_stays_dark() {
        let mut light = vec![None; 8];
        fill(&mut light, UVec3::splat(2));
        assert!(light.iter().all(Option::is_none));
    }
}

//! The placement of the levels, which the receiver reads from the last slice of the texture. Keep in sync with
//! `receive.wesl`.
//!
//! It is written where it changes, which it may do in frames in which no light is computed: levels follow in steps of voxels,
//! and in between their focus moves.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
        },
        renderer::RenderQueue,
        texture::GpuImage,
    },
};
use half::f16;

use crate::extract::placement::{PlacedLevel, PlacedVolume};

/// The four channels of a texel.
type Texel = [f16; 4];

/// The texels as they are in the texture.
#[derive(Default)]
pub(super) struct LevelTable {
    numbers: Vec<Texel>,
    focus: [Vec<Texel>; 2],
}

impl LevelTable {
    /// Writes what has changed.
    pub(super) fn write(&mut self, volume: &PlacedVolume, texture: &GpuImage, queue: &RenderQueue) {
        let size = texture.texture_descriptor.size;
        let row = |texels: &[Texel], y: u32| {
            queue.write_texture(
                TexelCopyTextureInfo {
                    texture: &texture.texture,
                    mip_level: 0,
                    origin: Origin3d {
                        x: 0,
                        y,
                        z: size.depth_or_array_layers - 1,
                    },
                    aspect: TextureAspect::All,
                },
                &bytes(texels),
                TexelCopyBufferLayout::default(),
                Extent3d {
                    width: texels.len() as u32,
                    height: 1,
                    depth_or_array_layers: 1,
                },
            );
        };
        let numbers = numbers(volume);
        if self.numbers != numbers {
            for (texels, y) in numbers.chunks(size.width as usize).zip(0..) {
                row(texels, y);
            }
            self.numbers = numbers;
        }
        let focus = [offsets(volume), cascades(volume)];
        if self.focus != focus {
            for (texels, y) in focus.iter().zip(size.height - 2..) {
                row(texels, y);
            }
            self.focus = focus;
        }
    }
}

fn bytes(texels: &[Texel]) -> Vec<u8> {
    let channels = texels.iter().flatten();
    channels.flat_map(|channel| channel.to_le_bytes()).collect()
}

/// Four integers of 8 bits, which 16-bit floats represent exactly.
fn packed(number: f32) -> Texel {
    number.to_le_bytes().map(f16::from)
}

/// The number of levels, the edges of the box around them, and for each its corner from the middle of the box, the edge of
/// a voxel, and the factor of its light.
fn numbers(volume: &PlacedVolume) -> Vec<Texel> {
    let levels = volume.lit();
    let (center, extent) = volume.bounds();
    let mut numbers = vec![levels.len() as f32];
    numbers.extend(extent.to_array());
    for level in levels {
        let corner = level.center - 0.5 * level.size - center;
        numbers.extend(corner.to_array());
        numbers.extend([volume.voxel_size(level), level.intensity]);
    }
    numbers.into_iter().map(packed).collect()
}

/// The focus of each level from its middle in its voxels, and how far it may be from there along an axis.
fn offsets(volume: &PlacedVolume) -> Vec<Texel> {
    let levels = volume.lit().iter();
    let offset = |level: &PlacedLevel| {
        let offset = (level.focus - level.center) / volume.voxel_size(level);
        texel(offset, volume.reach(level))
    };
    levels.map(offset).collect()
}

/// Half of the same from the middle of the largest level. That of the level is the nearest whose coordinates are integers.
fn cascades(volume: &PlacedVolume) -> Vec<Texel> {
    let levels = volume.lit();
    let largest = levels.last().map_or(Vec3::ZERO, |level| level.center);
    let focus = |level: &PlacedLevel| {
        let voxel_size = volume.voxel_size(level);
        let middle = ((level.center - largest) / (2.0 * voxel_size)).round();
        let offset = (level.focus - level.center) / (2.0 * voxel_size);
        // As near to the next one as 16-bit floats tell.
        let most = Vec3::splat(0.49);
        texel(middle + offset.clamp(-most, most), volume.reach(level))
    };
    levels.iter().map(focus).collect()
}

fn texel(v: Vec3, w: f32) -> Texel {
    [v.x, v.y, v.z, w].map(f16::from_f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level of 16 voxels of this edge.
    fn level(center: Vec3, focus: Vec3, voxel_size: f32) -> PlacedLevel {
        PlacedLevel {
            focus,
            ..PlacedLevel::of(center, 16.0 * voxel_size)
        }
    }

    #[test]
    fn numbers_are_those_of_the_levels_bit_by_bit() {
        let mut volume = PlacedVolume::of(vec![level(Vec3::X / 3.0, Vec3::ZERO, 0.1)]);
        volume.settings.resolution = 16;
        let read = |texel: &Texel| f32::from_le_bytes(texel.map(|byte| byte.to_f32() as u8));
        let found: Vec<f32> = numbers(&volume).iter().map(read).collect();
        let (center, extent) = volume.bounds();
        let corner = Vec3::X / 3.0 - 0.8 - center;
        let expected = [
            vec![1.0],
            extent.to_array().to_vec(),
            corner.to_array().to_vec(),
            vec![0.1, 1.0],
        ];
        assert_eq!(found, expected.concat());
    }

    #[test]
    fn the_middle_of_a_cascade_is_nearest_to_its_focus() {
        for x in [-3.3_f32, 0.0, 0.49, 0.5, 0.51, 77.7] {
            let at = Vec3::new(x, -x, 0.3);
            let levels = (0..5).map(|cascade| {
                let voxel_size = (1 << cascade) as f32 * 0.25;
                let step = if cascade == 4 { 1.0 } else { 2.0 } * voxel_size;
                level((at / step).round() * step, at, voxel_size)
            });
            let mut volume = PlacedVolume::of(levels.collect());
            volume.settings.resolution = 16;
            let levels = volume.lit();
            for (texel, level) in cascades(&volume).iter().zip(levels) {
                let half = Vec3::from_array([0, 1, 2].map(|axis| texel[axis].to_f32()));
                let voxel_size = volume.voxel_size(level);
                let middle = (level.center - levels[4].center) / voxel_size;
                assert_eq!(2.0 * half.round(), middle, "{x}");
                let from_focus = level.focus - levels[4].center - 2.0 * half * voxel_size;
                assert!(from_focus.length() <= 0.05 * voxel_size, "{x} {from_focus}");
            }
        }
    }
}

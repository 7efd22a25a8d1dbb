//! Generation of mip levels in linear light.
//!
//! Means of alpha are flatter than a mask, so fewer of them reach the material's cutoff from level to level, and
//! leaves vanish with distance. Each level's alpha is therefore scaled until its coverage is that of the finest level:
//! the part of the area that a material shows, as its texture is filtered bilinearly (I. Castaño, *Computing Alpha
//! Mipmaps*, 2010).

use super::texel::TexelFormat;
use crate::reference::texture::area_weights;

/// Number of positions along each axis of a texel at which the mask is sampled.
const POSITIONS: u32 = 8;

/// Scales beyond these powers of two are not tried. Thin masks need large ones.
pub(super) const LOG_SCALES: [f32; 2] = [-3.0, 8.0];

/// What the texels of a texture mean, which decides how they are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy::prelude::Reflect))]
#[non_exhaustive]
pub enum MipContent {
    /// Values that are averaged channel by channel, such as opaque colours, premultiplied colours and roughness.
    #[default]
    Values,
    /// Unit vectors, with -1 to 1 stored as 0 to 1 in the first three channels. They are renormalized to length 1.
    Normals,
    /// Colours with straight alpha, by which they are weighted: what is invisible does not bleed into what is
    /// visible. Where all texels have alpha 0, colours have equal weights.
    Transparent,
    /// Colours as in [`MipContent::Transparent`], of which a material shows those with at least this alpha, 0 to 1.
    /// The alpha of each level is scaled so that the visible part of the area stays the same.
    Mask {
        /// The least alpha that is visible.
        cutoff: f32,
    },
}

/// All mip levels of a texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MipChain {
    /// The texels of all levels, the finest first.
    pub data: Vec<u8>,
    /// Number of levels, at least 1.
    pub levels: u32,
}

/// Generates the full mip chain of a texture from its finest level; `None` if a side of `size` is 0 or
/// `data` is not as long as a level of that size.
///
/// A texel is the mean in linear light of the area that it covers in the next finer level, which also
/// holds for odd sizes. Formats with fewer channels than their content needs are averaged as
/// [`MipContent::Values`].
pub fn generate_mip_chain(
    size: [u32; 2],
    format: TexelFormat,
    data: Vec<u8>,
    content: MipContent,
) -> Option<MipChain> {
    let texels = size[0] as usize * size[1] as usize;
    if texels == 0 || data.len() != texels * format.bytes() {
        return None;
    }
    let content = match (content, format.channels) {
        (MipContent::Normals, 3..) | (_, 4) => content,
        _ => MipContent::Values,
    };
    let is_weighted = matches!(content, MipContent::Transparent | MipContent::Mask { .. });
    let mut size = size;
    let mut values = format.decode(&data);
    let visible = match content {
        MipContent::Mask { cutoff } => coverage(&values, size, cutoff, 1.0),
        _ => 0.0,
    };
    let mut data = data;
    let mut levels = 1;
    while size != [1, 1] {
        let next = size.map(|n| (n / 2).max(1));
        values = downsampled(&values, size, next, format.channels, is_weighted);
        size = next;
        // The next level is computed from the means before this step: there, rough areas have shorter normals and
        // correctly count less.
        match content {
            MipContent::Values | MipContent::Transparent => format.encode(&values, &mut data),
            MipContent::Normals => format.encode(&normalized(&values, format.channels), &mut data),
            MipContent::Mask { cutoff } => {
                let scale = coverage_scale(&values, size, cutoff, visible);
                let mut scaled = values.clone();
                let alphas = scaled.iter_mut().skip(3).step_by(4);
                alphas.for_each(|alpha| *alpha = (*alpha * scale).min(1.0));
                format.encode(&scaled, &mut data);
            }
        }
        levels += 1;
    }
    Some(MipChain { data, levels })
}

/// Returns the next level, whose texels are means of the areas that they cover.
fn downsampled(
    values: &[f32],
    from: [u32; 2],
    to: [u32; 2],
    channels: usize,
    is_weighted: bool,
) -> Vec<f32> {
    let rows = area_weights(from[1], to[1]);
    let columns = area_weights(from[0], to[0]);
    let mut result = Vec::with_capacity(to[0] as usize * to[1] as usize * channels);
    for row in &rows {
        for column in &columns {
            let covered = row.iter().flat_map(|&(y, wy)| {
                column.iter().map(move |&(x, wx)| {
                    let start = (y as usize * from[0] as usize + x as usize) * channels;
                    (&values[start..start + channels], (wx * wy) as f32)
                })
            });
            let mut mean = [0.0; 4];
            let mut weighted = [0.0; 4];
            for (texel, weight) in covered {
                for (channel, value) in texel.iter().enumerate() {
                    mean[channel] += weight * value;
                    weighted[channel] += weight * value * if is_weighted { texel[3] } else { 0.0 };
                }
            }
            if is_weighted && mean[3] > 0.0 {
                for channel in 0..3 {
                    mean[channel] = weighted[channel] / mean[3];
                }
            }
            result.extend(&mean[..channels]);
        }
    }
    result
}

fn normalized(values: &[f32], channels: usize) -> Vec<f32> {
    let mut result = values.to_vec();
    for texel in result.chunks_exact_mut(channels) {
        let normal = [0, 1, 2].map(|i| texel[i] * 2.0 - 1.0);
        let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt();
        if length > 1e-3 {
            for (channel, n) in texel.iter_mut().zip(normal) {
                *channel = n / length * 0.5 + 0.5;
            }
        }
    }
    result
}

/// Returns the part of the area, 0 to 1, where the scaled alpha of an RGBA level is at least `cutoff`.
fn coverage(values: &[f32], size: [u32; 2], cutoff: f32, scale: f32) -> f64 {
    let alpha = |x: i64, y: i64| {
        let x = x.clamp(0, i64::from(size[0]) - 1) as usize;
        let y = y.clamp(0, i64::from(size[1]) - 1) as usize;
        (values[(y * size[0] as usize + x) * 4 + 3] * scale).min(1.0)
    };
    let along = |n: u32| {
        (0..n * POSITIONS).map(|i| {
            let position = (f64::from(i) + 0.5) / f64::from(POSITIONS) - 0.5;
            (position.floor() as i64, position.rem_euclid(1.0) as f32)
        })
    };
    let mut visible = 0_u64;
    for (y, fy) in along(size[1]) {
        for (x, fx) in along(size[0]) {
            let row = |y| alpha(x, y) * (1.0 - fx) + alpha(x + 1, y) * fx;
            visible += u64::from(row(y) * (1.0 - fy) + row(y + 1) * fy >= cutoff);
        }
    }
    visible as f64 / (f64::from(size[0] * POSITIONS) * f64::from(size[1] * POSITIONS))
}

/// Returns the factor of a level's alpha that brings its coverage next to `visible`.
fn coverage_scale(values: &[f32], size: [u32; 2], cutoff: f32, visible: f64) -> f32 {
    if visible <= 0.0 || visible >= 1.0 {
        return 1.0;
    }
    let [mut low, mut high] = LOG_SCALES;
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if coverage(values, size, cutoff, middle.exp2()) < visible {
            low = middle;
        } else {
            high = middle;
        }
    }
    let error = |log: f32| (coverage(values, size, cutoff, log.exp2()) - visible).abs();
    (if error(low) < error(high) { low } else { high }).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mips::texel::Storage;

    const RGBA: TexelFormat = TexelFormat {
        channels: 4,
        storage: Storage::Unorm8,
        srgb: false,
    };
    const SRGB: TexelFormat = TexelFormat { srgb: true, ..RGBA };

    fn chain(size: [u32; 2], format: TexelFormat, data: Vec<u8>, content: MipContent) -> MipChain {
        generate_mip_chain(size, format, data, content).expect("a chain")
    }

    #[test]
    fn srgb_stripes_become_the_gray_of_their_light() {
        // Thesis figure 5.13: the mean of black and white is 188 and not 128; alpha is linear.
        let data = [[0, 0, 0, 0], [255; 4]].concat().repeat(8);
        let chain = chain([4, 4], SRGB, data, MipContent::Values);
        assert_eq!(chain.levels, 3);
        assert_eq!(&chain.data[64..], [188, 188, 188, 128].repeat(5));
    }

    #[test]
    fn odd_sizes_count_every_texel_once() {
        let data: Vec<u8> = [0, 0, 0, 0, 255].repeat(3);
        let format = TexelFormat {
            channels: 1,
            ..RGBA
        };
        let chain = chain([5, 3], format, data, MipContent::Values);
        // The levels are 5 x 3, 2 x 1 and 1 x 1. A texel of the second covers 2.5 columns, and the right
        // one of them contains the white column.
        assert_eq!(chain.data[15..], [0, 102, 51]);
    }

    #[test]
    fn normals_keep_their_length() {
        let up_left = [37, 128, 218, 255];
        let up_right = [218, 128, 218, 255];
        let data = [up_left, up_right].concat();
        let chain = chain([2, 1], RGBA, data, MipContent::Normals);
        assert_eq!(chain.data[8..], [128, 128, 255, 255]);
    }

    #[test]
    fn invisible_colours_do_not_bleed_into_visible_ones() {
        let leaf = [40, 110, 30, 255];
        let data = [leaf, [0; 4], [0; 4], [0; 4]].concat();
        let level = |content| {
            let chain = chain([2, 2], SRGB, data.clone(), content);
            chain.data[16..].to_vec()
        };
        assert_eq!(level(MipContent::Transparent), [40, 110, 30, 64]);
        assert_eq!(level(MipContent::Values)[3], 64);
        assert!(level(MipContent::Values)[1] < 60, "a quarter of the light");
        // Nothing is visible: the colour is the plain mean.
        let clear = [[188, 188, 188, 0], [188, 188, 188, 0]].concat();
        let chain = chain([2, 1], SRGB, clear, MipContent::Transparent);
        assert_eq!(chain.data[8..], [188, 188, 188, 0]);
    }

    #[test]
    fn floats_and_every_size_down_to_one_texel() {
        let format = TexelFormat {
            channels: 2,
            storage: Storage::Float32,
            srgb: false,
        };
        for size in [[1, 1], [7, 1], [1, 5], [16, 3]] {
            let texels = (size[0] * size[1]) as usize;
            let data = [2.5f32, -1.0]
                .map(f32::to_le_bytes)
                .as_flattened()
                .repeat(texels);
            let chain = chain(size, format, data, MipContent::Values);
            for value in format.decode(&chain.data).chunks_exact(2) {
                assert!((value[0] - 2.5).abs() < 1e-6 && (value[1] + 1.0).abs() < 1e-6);
            }
            assert_eq!(chain.levels, size[0].max(size[1]).ilog2() + 1);
        }
    }

    #[test]
    fn sixteen_bits_keep_what_eight_would_round_away() {
        // Values that 8 bits cannot represent.
        let data = |values: [u16; 2]| values.map(u16::to_le_bytes).as_flattened().to_vec();
        for (storage, pair, mean) in [
            (Storage::Unorm16, [1000, 1003], 1002),
            // The values 2048 and 2056.
            (Storage::Float16, [0x6800, 0x6804], 0x6802),
            // The values -1 and 65504, the largest finite one.
            (Storage::Float16, [0xbc00, 0x7bff], 0x77ff),
        ] {
            let format = TexelFormat {
                channels: 1,
                storage,
                srgb: false,
            };
            let chain = chain([2, 1], format, data(pair), MipContent::Values);
            assert_eq!(chain.levels, 2);
            assert_eq!(
                chain.data[4..],
                u16::to_le_bytes(mean),
                "{storage:?} {pair:?}"
            );
        }
    }

    #[test]
    fn data_of_another_size_is_refused() {
        assert_eq!(
            generate_mip_chain([2, 2], RGBA, vec![0; 15], MipContent::Values),
            None
        );
        assert_eq!(
            generate_mip_chain([0, 2], RGBA, Vec::new(), MipContent::Values),
            None
        );
    }

    const GRASS_SIZE: u32 = 64;

    /// The coverage of all levels but the last two, which are hardly more than one value.
    fn coverages(content: MipContent, cutoff: f32) -> Vec<f64> {
        // Blades of grass: slanted lines of 2 texels, 19% of the area.
        let texel = |i: u32| {
            let is_blade = (i % GRASS_SIZE + i / GRASS_SIZE / 3) % 11 < 2;
            [60, 120, 40, if is_blade { 255 } else { 0 }]
        };
        let data: Vec<u8> = (0..GRASS_SIZE * GRASS_SIZE).flat_map(texel).collect();
        let chain = chain([GRASS_SIZE; 2], SRGB, data, content);
        let mut start = 0;
        let coverages = (0..chain.levels - 2).map(|level| {
            let side = GRASS_SIZE >> level;
            let end = start + (side * side * 4) as usize;
            let values = SRGB.decode(&chain.data[start..end]);
            start = end;
            coverage(&values, [side; 2], cutoff, 1.0)
        });
        coverages.collect()
    }

    #[test]
    fn masks_keep_their_coverage() {
        for cutoff in [0.25, 0.5, 0.75] {
            let kept = coverages(MipContent::Mask { cutoff }, cutoff);
            for (level, coverage) in kept.iter().enumerate() {
                let difference = coverage - kept[0];
                assert!(difference.abs() < 0.01, "{cutoff}, level {level}: {kept:?}");
            }
        }
        // The mean alpha alone loses all blades.
        let lost = coverages(MipContent::Transparent, 0.5);
        assert!(lost[0] > 0.15 && lost[3] == 0.0, "{lost:?}");
    }
}

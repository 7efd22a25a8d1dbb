//! The error of a wavelet image against its source, and the parts of an image by which encodings are compared before
//! all of it is encoded.

use rayon::prelude::*;

use super::{
    blocks::decode_blocks,
    color::ycocg_from_rgb,
    decoder::LevelRows,
    image::{Content, WaveletImage},
    layout::mip_size,
    source::{Source, unit},
};

/// PSNR of the largest level in dB, with both images rounded to 8 bits: over R, G and B (and alpha
/// where it is kept), over luma for gray, over X, Y and Z of unit vectors for normals. It is infinite
/// where the images are identical.
pub fn psnr_db(source: &Source<'_>, image: &WaveletImage) -> f64 {
    psnr_of(mse(source, image))
}

/// Mean squared error of the same, in 8-bit units squared.
pub fn mse(source: &Source<'_>, image: &WaveletImage) -> f64 {
    level_mse(source, image, 0, &[])[0]
}

/// How much a mip level is used, against the largest one: each half as much as the one before.
///
/// A surface shows each level over about as many pixels of the screen as the others, but the smaller ones where it is
/// far away, and seldom those of a few pixels.
pub(super) fn level_weight(level: usize) -> f64 {
    0.5f64.powi(level as i32)
}

/// Mean squared errors of all levels, by how much they are used, in 8-bit units squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Errors {
    /// That of all channels.
    pub(super) all: f64,
    /// The part of it that is that of luma: how large the error of colour would be if chroma had none.
    pub(super) luma: f64,
    /// That of all channels in the windows of each level.
    pub(super) in_windows: f64,
}

impl Errors {
    /// Measures an image. `windows` are those of at least its levels.
    pub(super) fn of(source: &Source<'_>, image: &WaveletImage, windows: &[Vec<Window>]) -> Self {
        let (mut sums, mut weights) = ([0.0; 3], 0.0);
        for (level, windows) in (0..image.levels).zip(windows) {
            let weight = level_weight(level as usize);
            let errors = level_mse(source, image, level, windows);
            sums = [0, 1, 2].map(|i| sums[i] + weight * errors[i]);
            weights += weight;
        }
        let [all, luma, in_windows] = sums.map(|sum| sum / weights);
        Self {
            all,
            luma,
            in_windows,
        }
    }
}

/// The mean squared error of all channels of a level with both images rounded to 8 bits, that of luma, and that of all
/// channels in windows.
fn level_mse(
    source: &Source<'_>,
    image: &WaveletImage,
    level: u32,
    windows: &[Window],
) -> [f64; 3] {
    let rows = LevelRows::new(image, level, decode_blocks);
    let pixels = &source.levels[level as usize];
    let content = image.content;
    let axis = image.axes().weights()[0];
    let luma = |pixel: [f32; 4]| (0..3).map(|c| 255.0 * axis[c] * pixel[c]).sum::<f32>();
    let [width, height] = rows.size;
    let of_row = |(row, errors): &mut (Vec<[f32; 4]>, Vec<u32>), y: u32| {
        rows.fill(y, row);
        let mut of_luma = 0.0;
        for (x, (decoded, error)) in row.iter().zip(errors.iter_mut()).enumerate() {
            let expected = pixels.get(y as usize * width as usize + x);
            *error = pixel_error(content, expected, *decoded);
            of_luma += f64::from(luma(expected) - luma(*decoded)).powi(2);
        }
        let in_window = |window: &Window| {
            let [left, top] = window.corner;
            let errors = &errors[left as usize..][..window.size[0] as usize];
            match (top..top + window.size[1]).contains(&y) {
                true => errors.iter().map(|error| u64::from(*error)).sum(),
                false => 0,
            }
        };
        let all: u64 = errors.iter().map(|error| u64::from(*error)).sum();
        let of_windows: u64 = windows.iter().map(in_window).sum();
        [all as f64, of_luma, of_windows as f64]
    };
    // Row by row, so that the sum does not depend on the number of threads.
    let row = || (vec![[0.0; 4]; width as usize], vec![0; width as usize]);
    let sums: Vec<[f64; 3]> = (0..height).into_par_iter().map_init(row, of_row).collect();
    let sum = |i: usize| sums.iter().map(|sums| sums[i]).sum::<f64>();
    let channels = content.error_channels() as f64;
    let count = f64::from(width) * f64::from(height);
    let window_pixels: usize = windows.iter().map(Window::pixels).sum();
    [
        sum(0) / (count * channels),
        sum(1) / count,
        sum(2) / (window_pixels as f64 * channels),
    ]
}

/// The sum of the squared errors of the channels of a pixel that was decoded to `[0, 1]`, or to a unit vector, with both
/// rounded to 8 bits.
#[inline]
pub(super) fn pixel_error(content: Content, mut expected: [f32; 4], decoded: [f32; 4]) -> u32 {
    match content {
        Content::Gray => {
            expected[0] = ycocg_from_rgb([expected[0], expected[1], expected[2]]).y;
        }
        // Only the direction counts, as in the game: maps have vectors of other lengths, too.
        Content::Normal => {
            let [x, y, z] = unit(expected).map(|v| 0.5 + 0.5 * v);
            expected = [x, y, z, 1.0];
        }
        Content::Color | Content::ColorAlpha => {}
    }
    // `f32::round` would be a call of a library.
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    let of_channel = |c: usize| {
        let decoded = match content {
            Content::Normal => 0.5 + 0.5 * decoded[c],
            _ => decoded[c],
        };
        u32::from(byte(expected[c]).abs_diff(byte(decoded))).pow(2)
    };
    (0..content.error_channels()).map(of_channel).sum()
}

/// Converts a mean squared error, in 8-bit units squared, to a PSNR in dB.
pub fn psnr_of(mse: f64) -> f64 {
    10.0 * (255.0 * 255.0 / mse).log10()
}

/// Width and height of a window in pixels.
const SIDE: u32 = 64;

/// Number of windows of the largest level; each further one has half as many as the one before.
const COUNT: u32 = 32;

/// Pixels of a level.
pub(super) struct Window {
    pub(super) corner: [u32; 2],
    pub(super) size: [u32; 2],
}

impl Window {
    /// Windows all over each level of an image, or the whole of a level that has no more pixels than its windows.
    pub(super) fn of_levels(image_size: [u32; 2], levels: usize) -> Vec<Vec<Self>> {
        let of_level =
            |level: u32| Self::of_level(mip_size(image_size, level), (COUNT >> level).max(1));
        (0..levels as u32).map(of_level).collect()
    }

    fn of_level(size: [u32; 2], count: u32) -> Vec<Self> {
        let [width, height] = size.map(f64::from);
        if width * height <= f64::from(count * SIDE * SIDE) {
            return vec![Self {
                corner: [0, 0],
                size,
            }];
        }
        // Cells of a grid, each with a window somewhere in it.
        let most = size.map(|s| s.div_ceil(SIDE));
        let across = (f64::from(count) * width / height).sqrt().round() as u32;
        let columns = across
            .clamp(count.div_ceil(most[1]).min(most[0]), most[0])
            .max(1);
        let rows = (count / columns).clamp(1, most[1]);
        let window = |cell: u32| {
            let at = [cell % columns, cell / columns];
            // Positions that do not repeat from cell to cell, by the golden ratio.
            let place = [cell, cell / columns + 7 * cell]
                .map(|i| u64::from(i.wrapping_mul(0x9e37_79b9) >> 16));
            let window = [0, 1].map(|axis: usize| {
                let cells = u64::from([columns, rows][axis]);
                let [start, end] = [0, 1]
                    .map(|i| (u64::from(at[axis] + i) * u64::from(size[axis]) / cells) as u32);
                let side = SIDE.min(end - start);
                let free = u64::from(end - start - side + 1);
                [start + ((place[axis] * free) >> 16) as u32, side]
            });
            Self {
                corner: window.map(|[corner, _]| corner),
                size: window.map(|[_, side]| side),
            }
        };
        (0..columns * rows).map(window).collect()
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

/// Normals in pixels of 8 bits, and the angles between them, which measure the error of normal maps.
pub mod angle {
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_inside_and_apart() {
        for size in [
            [2048, 2048],
            [16384, 1],
            [3, 9000],
            [1000, 600],
            [513, 4097],
            [7, 5],
        ] {
            for (level, windows) in Window::of_levels(size, 4).iter().enumerate() {
                let size = mip_size(size, level as u32);
                let pixels: usize = windows.iter().map(Window::pixels).sum();
                assert!(pixels <= (COUNT * SIDE * SIDE) as usize >> level);
                let all = size[0] as usize * size[1] as usize;
                assert!(pixels == all || 4 * pixels >= all.min(pixels * 4) && windows.len() > 1);
                for (i, a) in windows.iter().enumerate() {
                    let inside = (0..2).all(|c| a.corner[c] + a.size[c] <= size[c]);
                    assert!(inside && a.pixels() > 0, "{size:?}");
                    for b in &windows[..i] {
                        let is_apart = (0..2).any(|c| {
                            a.corner[c] + a.size[c] <= b.corner[c]
                                || b.corner[c] + b.size[c] <= a.corner[c]
                        });
                        assert!(is_apart, "{size:?}");
                    }
                }
            }
        }
    }
}

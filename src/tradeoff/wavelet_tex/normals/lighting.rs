//! A rendering of a highlight on a normal map in different formats (thesis Fig. 3.24).

use bevy_wavelet_tex::codec::angle::unit;
use image::{Rgb, RgbImage};

use super::map::NormalMap;

/// Pixels of the picture in x and y for one pixel of the map.
const MAGNIFICATION: u32 = 2;

/// Side of the shown part of the map and its corner, in pixels. The highlight is in the middle.
const PART: u32 = 160;
const CORNER: [u32; 2] = [30, 90];

/// Exponent of the highlight, small enough that the brightness changes slowly.
const SHININESS: f64 = 60.0;

/// Factor by which errors are amplified.
const GAIN: f64 = 10.0;

/// Direction toward the light. The viewer is at +Z.
const LIGHT: [f64; 3] = [0.36, 0.48, 0.8];

/// Renders the lit maps side by side, and below each its difference in brightness from the first.
pub fn picture(maps: &[&NormalMap]) -> RgbImage {
    let lit: Vec<Vec<f64>> = maps.iter().map(|map| lit(map)).collect();
    let side = PART * MAGNIFICATION;
    RgbImage::from_fn(side * maps.len() as u32, 2 * side, |x, y| {
        let (panel, i) = ((x / side) as usize, (y % side * side + x % side) as usize);
        let value = if y < side {
            lit[panel][i]
        } else {
            0.5 + GAIN * (lit[panel][i] - lit[0][i])
        };
        Rgb([(255.0 * value.clamp(0.0, 1.0)).round() as u8; 3])
    })
}

/// Brightness of the lit map in display-referred units, from 0; it can exceed 1.
fn lit(map: &NormalMap) -> Vec<f64> {
    let shown = map.interpolated_to(map.size.map(|s| s * MAGNIFICATION));
    let width = (map.size[0] * MAGNIFICATION) as usize;
    let side = (PART * MAGNIFICATION) as usize;
    let [left, top] = CORNER.map(|v| (v * MAGNIFICATION) as usize);
    let half = unit([LIGHT[0], LIGHT[1], LIGHT[2] + 1.0]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    (0..side * side)
        .map(|i| {
            let normal = unit(shown[(top + i / side) * width + left + i % side]);
            let diffuse = dot(normal, LIGHT).max(0.0);
            let highlight = dot(normal, half).max(0.0).powf(SHININESS);
            0.25 * diffuse + 0.7 * highlight
        })
        .collect()
}

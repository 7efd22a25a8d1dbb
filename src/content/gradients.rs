//! Smooth ramps, in which banding and quantisation show first.

use super::color::{Color, hex, hue, mix, ramp, shade};
use super::lattice::lerp;
use super::material::{Border, Material, Sample, render, units};

const DUSK: [Color; 5] = [
    hex(0x101A3A),
    hex(0x3A3F73),
    hex(0xA8627E),
    hex(0xF0A36B),
    hex(0xFBE3B0),
];

/// Six panels in two rows. Top: all hues against brightness, a dusk sky, a glow in the dark.
/// Bottom: the eight darkest grays stretched over a panel, a saturated crossfade of four colours,
/// and a grayscale. Panels that would be the same for every seed are turned by it. Does not tile;
/// the normals are one smooth dome per panel, the mask is a radial falloff.
pub fn gradients(width: u32, height: u32, seed: u64) -> Material {
    let turn = (seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f32 / (1u64 << 24) as f32;
    let units = units(width, height).map(|units| units as f32);
    render(width, height, Border::Clamp, |[x, y]| {
        sample(x / units[0], y / units[1], turn)
    })
}

/// The sample at a point of the unit square.
fn sample(x: f32, y: f32, turn: f32) -> Sample {
    let (column, row) = ((x * 3.0).floor().min(2.0), (y * 2.0).floor().min(1.0));
    let (s, t) = (x * 3.0 - column, y * 2.0 - row);
    let radius = (s - 0.5).hypot(t - 0.5) * std::f32::consts::SQRT_2;

    let color = match (row as u32, column as u32) {
        (0, 0) => {
            let pure = hue(s + turn);
            if t < 0.5 {
                shade(pure, t * 2.0)
            } else {
                mix(pure, [1.0; 3], t * 2.0 - 1.0)
            }
        }
        (0, 1) => ramp(&DUSK, t + 0.08 * (s - 0.5)),
        (0, _) => shade(
            mix(hue(turn), [1.0; 3], 0.6),
            (1.0 - radius).max(0.0).powi(2) * 0.7,
        ),
        (_, 0) => [lerp(0.0, 8.0 / 255.0, s); 3],
        (_, 1) => {
            let corner = |quarter: f32| hue(turn + quarter);
            mix(
                mix(corner(0.0), corner(0.25), s),
                mix(corner(0.5), corner(0.75), s),
                t,
            )
        }
        _ => [lerp(1.0, 0.0, t); 3],
    };
    let wave = |v: f32| (v * std::f32::consts::PI).sin();
    Sample {
        color,
        height: 0.06 * wave(s) * wave(t),
        mask: 1.0 - radius,
    }
}

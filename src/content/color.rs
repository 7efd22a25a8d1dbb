//! Colours as sRGB-encoded triples of 0 to 1, mixed as such: even steps to the eye.

use super::lattice::lerp;

/// An sRGB-encoded colour, channels 0 to 1.
pub(super) type Color = [f32; 3];

/// The colour of a hexadecimal code such as `0xB2_55_3C`.
pub(super) const fn hex(code: u32) -> Color {
    [
        ((code >> 16) & 0xFF) as f32 / 255.0,
        ((code >> 8) & 0xFF) as f32 / 255.0,
        (code & 0xFF) as f32 / 255.0,
    ]
}

/// Interpolates from `a` to `b`.
pub(super) fn mix(a: Color, b: Color, t: f32) -> Color {
    [0, 1, 2].map(|c| lerp(a[c], b[c], t))
}

/// Multiplies the brightness.
pub(super) fn shade(color: Color, factor: f32) -> Color {
    color.map(|channel| channel * factor)
}

/// Interpolates along evenly spaced colours; `t` is clamped to 0 to 1.
pub(super) fn ramp(stops: &[Color], t: f32) -> Color {
    let position = t.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
    let index = (position as usize).min(stops.len() - 2);
    mix(stops[index], stops[index + 1], position - index as f32)
}

/// Fully saturated colour of a hue of 0 to 1 (red, green, blue, red).
pub(super) fn hue(turn: f32) -> Color {
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|offset| {
        let distance = ((turn + offset).rem_euclid(1.0) - 0.5).abs();
        (distance * 6.0 - 1.0).clamp(0.0, 1.0)
    })
}

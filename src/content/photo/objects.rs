//! Things made by people: smooth shading, straight edges and saturated paint.

use super::super::color::{Color, hex, mix, shade};
use super::super::lattice::{Noise, smoothstep};

const PAINTS: [Color; 6] = [
    hex(0xC22A2E),
    hex(0xE9B52C),
    hex(0x2567A8),
    hex(0x3A8F5B),
    hex(0xE8E2D4),
    hex(0xD96C2B),
];

/// The hot-air balloon that covers a point of the sky, if one does.
pub(super) fn balloons(noise: Noise, point: [f32; 2], aspect: f32) -> Option<Color> {
    (0..4).find_map(|i| {
        let random = |stream: u32| noise.stream(stream).uniform(i, 0);
        // Each in its own quarter of the width, the nearest first.
        let column = (i * 3 + 2) % 4;
        let radius = 0.105 - 0.022 * i as f32;
        let center = [
            aspect * (column as f32 + 0.3 + 0.4 * random(0)) / 4.0,
            0.13 + 0.16 * random(1) + 0.02 * i as f32,
        ];
        balloon(
            [
                (point[0] - center[0]) / radius,
                (point[1] - center[1]) / radius,
            ],
            [random(2), random(3)],
        )
    })
}

/// A balloon of radius 1 around the origin.
fn balloon([x, y]: [f32; 2], random: [f32; 2]) -> Option<Color> {
    // The envelope narrows to its mouth below.
    let half_width = if y < 0.25 {
        (1.0 - y * y).max(0.0).sqrt()
    } else {
        0.968 * (1.0 - smoothstep(0.25, 1.9, y)).max(0.0).powf(1.25)
    };
    let basket = (1.62..1.85).contains(&y) && x.abs() < 0.15;
    let rope = (1.3..1.62).contains(&y) && (x.abs() - 0.14).abs() < 0.012;
    if basket {
        let weave = ((y * 60.0).sin() * (x * 70.0).sin()).signum();
        return Some(shade(hex(0x7A4E28), 0.9 + 0.15 * weave - 0.6 * x));
    }
    if rope {
        return Some(hex(0x3B3129));
    }
    if y > 1.4 || x.abs() >= half_width {
        return None;
    }
    let turn = (x / half_width).asin();
    let gore = (turn / std::f32::consts::PI * 10.0 + 10.0 * random[0]).floor();
    let first = PAINTS[(random[0] * 6.0) as usize % 6];
    let second = PAINTS[((random[0] * 6.0) as usize + 1 + (random[1] * 4.0) as usize) % 6];
    let paint = match gore.rem_euclid(2.0) as i32 {
        _ if (-0.05..0.25).contains(&(y + 0.12 * (turn * 10.0).sin())) => PAINTS[4],
        0 => first,
        _ => second,
    };
    let normal = [turn.sin(), y.clamp(-1.0, 1.0)];
    let depth = (1.0 - normal[0] * normal[0] * 0.9 - normal[1] * normal[1] * 0.5)
        .max(0.0)
        .sqrt();
    let light = (-0.55 * normal[0] - 0.5 * normal[1] + 0.67 * depth).max(0.0);
    Some(mix(
        shade(paint, 0.32 + 0.75 * light),
        [1.0; 3],
        0.25 * smoothstep(0.9, 1.0, light),
    ))
}

/// The house that covers a point, if one does; they stand on the `shore`.
pub(super) fn houses(noise: Noise, [x, y]: [f32; 2], shore: f32) -> Option<Color> {
    const PITCH: f32 = 0.115;
    let cell = (x / PITCH).floor();
    let random = |stream: u32| noise.stream(stream).uniform(cell as i32, 0);
    if random(0) < 0.4 {
        return None;
    }
    let width = PITCH * (0.62 + 0.3 * random(1));
    let left = cell * PITCH + (PITCH - width) * random(2);
    let base = shore + 0.012 + 0.012 * random(3);
    let wall = 0.06 + 0.045 * random(4);
    let (s, t) = ((x - left) / width, (base - y) / wall);
    let texture = noise.stream(10).fractal([x, y], [50, 90], 4);

    // A gable roof over the wall, overhanging a little.
    let overhang = 0.06;
    let rise = (t - 1.0) * wall / (0.55 * width);
    let roof_edge = 1.0 - (s - 0.5).abs() / (0.5 + overhang);
    if t > 1.0 && rise < roof_edge {
        let tile = ((rise * 9.0).rem_euclid(1.0) - 0.5).abs() + 0.5 * texture;
        let fascia = smoothstep(0.10, 0.06, roof_edge - rise);
        let roof = mix(
            hex(0x7C3B2A),
            hex(0x46403F),
            smoothstep(0.45, 0.55, random(5)),
        );
        return Some(mix(shade(roof, 0.75 + 0.6 * tile), hex(0xE9E4DA), fascia));
    }
    if !(0.0..=1.0).contains(&s) || !(0.0..=1.0).contains(&t) {
        return None;
    }
    let paint = PAINTS[(random(6) * 6.0) as usize % 6];
    let board = ((t * wall * 170.0).rem_euclid(1.0) - 0.5).abs();
    let facade = shade(
        paint,
        0.82 + 0.14 * board + 0.1 * texture - 0.25 * smoothstep(0.9, 1.0, t),
    );
    let columns = if width > 0.085 { 4.0 } else { 3.0 };
    let (pane_s, pane_t) = ((s * columns).fract() - 0.5, (t * 2.0).fract() - 0.55);
    let frame = pane_s.abs().max(pane_t.abs() * 0.85);
    if frame > 0.29 {
        return Some(facade);
    }
    let mullion = pane_s.abs() < 0.035 || pane_t.abs() < 0.035;
    let glass = mix(
        hex(0x1C2A38),
        hex(0x9DB6C9),
        smoothstep(-0.3, 0.4, pane_t + pane_s + texture),
    );
    Some(if frame > 0.235 || mullion {
        hex(0xF3EFE6)
    } else {
        glass
    })
}

//! One channel: red, green or blue in B. E. Bayer's mosaic, with the demosaicing filter of H. S.
//! Malvar, L. He and R. Cutler, "High-Quality Linear Interpolation for Demosaicing of
//! Bayer-Patterned Color Images", ICASSP 2004.

use super::{super::frame::Frame, dither::quantized};

const RED: usize = 0;
const GREEN: usize = 1;
const BLUE: usize = 2;

/// Weights, in eighths, of the centre, the two neighbours along an axis and the two at twice the
/// distance, those across it, and the four diagonals.
struct Kernel {
    center: f32,
    along: [f32; 2],
    across: [f32; 2],
    diagonal: f32,
}

const GREEN_AT_OTHERS: Kernel = Kernel {
    center: 4.0,
    along: [2.0, -1.0],
    across: [2.0, -1.0],
    diagonal: 0.0,
};

/// Red or blue at green, from its two neighbours along an axis.
const AT_GREEN: Kernel = Kernel {
    center: 5.0,
    along: [4.0, -1.0],
    across: [0.0, 0.5],
    diagonal: -1.0,
};

const AT_OPPOSITE: Kernel = Kernel {
    center: 6.0,
    along: [0.0, -1.5],
    across: [0.0, -1.5],
    diagonal: 2.0,
};

/// The channel that a pixel stores.
fn stored_channel(x: u32, y: u32) -> usize {
    match (x % 2, y % 2) {
        (0, 0) => RED,
        (1, 1) => BLUE,
        _ => GREEN,
    }
}

pub fn bayer(picture: &Frame) -> Frame {
    let mosaic = Frame::from_fn(picture.size, |x, y| {
        [quantized(picture.at(x, y)[stored_channel(x, y)], 255.0, 0.0); 3]
    });
    Frame::from_fn(picture.size, |x, y| {
        let stored = stored_channel(x, y);
        let missing = |channel: usize| {
            if channel == stored {
                mosaic.at(x, y)[0]
            } else if channel == GREEN {
                filtered(&mosaic, x, y, &GREEN_AT_OTHERS, true)
            } else if stored == GREEN {
                // Rows of even numbers have red, the others blue.
                let horizontal = (y % 2 == 0) == (channel == RED);
                filtered(&mosaic, x, y, &AT_GREEN, horizontal)
            } else {
                filtered(&mosaic, x, y, &AT_OPPOSITE, true)
            }
        };
        [RED, GREEN, BLUE].map(missing)
    })
}

fn filtered(mosaic: &Frame, x: u32, y: u32, kernel: &Kernel, horizontal: bool) -> f32 {
    let at = |along: i64, across: i64| {
        let (dx, dy) = if horizontal {
            (along, across)
        } else {
            (across, along)
        };
        mosaic.mirrored(i64::from(x) + dx, i64::from(y) + dy)[0]
    };
    let pair = |distance: i64, weights: [f32; 2], is_along: bool| {
        let weight = weights[distance as usize - 1];
        let (a, b) = if is_along {
            (at(distance, 0), at(-distance, 0))
        } else {
            (at(0, distance), at(0, -distance))
        };
        weight * (a + b)
    };
    let sum = kernel.center * at(0, 0)
        + pair(1, kernel.along, true)
        + pair(2, kernel.along, true)
        + pair(1, kernel.across, false)
        + pair(2, kernel.across, false)
        + kernel.diagonal * (at(1, 1) + at(1, -1) + at(-1, 1) + at(-1, -1));
    (sum / 8.0).clamp(0.0, 1.0)
}

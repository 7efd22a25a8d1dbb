//! A third fewer pixels, enlarged again.
//!
//! The small picture is the area-weighted mean of the large one: kinder than rendering at that size,
//! which would alias.

use super::{super::frame::Frame, dither::quantized};

/// Enlarged by a bilinear filter, as samplers have it.
pub fn bilinear(picture: &Frame) -> Frame {
    enlarged(&reduced(picture), picture.size, 1, |d| (1.0 - d).max(0.0))
}

/// Enlarged by a bicubic filter (E. Catmull, R. Rom, 1974), 16 fetches.
pub fn bicubic(picture: &Frame) -> Frame {
    enlarged(&reduced(picture), picture.size, 2, |d| {
        if d < 1.0 {
            (1.5 * d - 2.5) * d * d + 1.0
        } else if d < 2.0 {
            ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0
        } else {
            0.0
        }
    })
}

/// Two thirds of the pixels, in 8 bits.
fn reduced(picture: &Frame) -> Frame {
    let scale = (2.0f32 / 3.0).sqrt();
    let size = picture
        .size
        .map(|side| ((side as f32 * scale).round() as u32).max(1));
    let span = |i: u32, axis: usize| {
        let step = picture.size[axis] as f32 / size[axis] as f32;
        let (start, end) = (i as f32 * step, (i + 1) as f32 * step);
        let last = (end.ceil() as u32).min(picture.size[axis]);
        (start as u32..last).map(move |pixel| {
            let covered = end.min(pixel as f32 + 1.0) - start.max(pixel as f32);
            (pixel, covered.max(0.0))
        })
    };
    Frame::from_fn(size, |x, y| {
        let mut sum = [0.0; 3];
        let mut area = 0.0;
        for (row, height) in span(y, 1) {
            for (column, width) in span(x, 0) {
                let color = picture.at(column, row);
                sum = [0, 1, 2].map(|c| sum[c] + width * height * color[c]);
                area += width * height;
            }
        }
        sum.map(|c| quantized(c / area, 255.0, 0.0))
    })
}

/// Weights pixels within `radius` of a point by `kernel` of their distances in x and y.
fn enlarged(small: &Frame, size: [u32; 2], radius: i64, kernel: impl Fn(f32) -> f32) -> Frame {
    Frame::from_fn(size, |x, y| {
        let position = |i: u32, axis: usize| {
            (i as f32 + 0.5) * small.size[axis] as f32 / size[axis] as f32 - 0.5
        };
        let (u, v) = (position(x, 0), position(y, 1));
        let mut sum = [0.0; 3];
        for row in v.floor() as i64 - radius + 1..=v.floor() as i64 + radius {
            for column in u.floor() as i64 - radius + 1..=u.floor() as i64 + radius {
                let weight = kernel((u - column as f32).abs()) * kernel((v - row as f32).abs());
                let color = small.clamped(column, row);
                sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
            }
        }
        sum.map(|c| c.clamp(0.0, 1.0))
    })
}

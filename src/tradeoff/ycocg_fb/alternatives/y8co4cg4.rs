//! 8 bits of luminance and 4 of each chrominance, with dither.

use bevy_ycocg_fb::reference::{
    YCoCg,
    color::{rgb_from_ycocg, ycocg_from_rgb},
};

use super::{
    super::frame::Frame,
    dither::{quantized, threshold},
};

/// Chrominance has 15 steps; the value that stands for 0 is one of them, so that grey stays grey.
const LEVELS: f32 = 15.0;
const BIAS: f32 = 8.0 / LEVELS;

pub fn y8co4cg4(picture: &Frame) -> Frame {
    Frame::from_fn(picture.size, |x, y| {
        let color = ycocg_from_rgb(picture.at(x, y));
        let threshold = threshold(x, y);
        let chrominance = |c: f32| quantized(c + BIAS, LEVELS, threshold) - BIAS;
        rgb_from_ycocg(YCoCg {
            y: quantized(color.y, 255.0, 0.0),
            co: chrominance(color.co),
            cg: chrominance(color.cg),
        })
    })
}

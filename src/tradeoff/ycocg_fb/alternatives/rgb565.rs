//! 5 bits of red, 6 of green and 5 of blue, with dither.

use super::{
    super::frame::Frame,
    dither::{quantized, threshold},
};

pub fn rgb565(picture: &Frame) -> Frame {
    Frame::from_fn(picture.size, |x, y| {
        let [r, g, b] = picture.at(x, y);
        let threshold = threshold(x, y);
        [(r, 31.0), (g, 63.0), (b, 31.0)].map(|(v, levels)| quantized(v, levels, threshold))
    })
}

//! Two channels: green everywhere, red and blue in a checkerboard, with the thesis's edge-directed
//! filter on the edges of green.

use bevy_ycocg_fb::reference::{
    PackedPixel,
    pack::stores_co,
    reconstruct::{Cross, edge_directed},
};

use super::{super::frame::Frame, dither::quantized};

pub fn rgb_checkerboard(picture: &Frame) -> Frame {
    let stored = Frame::from_fn(picture.size, |x, y| {
        let [r, g, b] = picture.at(x, y);
        let other = if stores_co(x, y) { r } else { b };
        [quantized(g, 255.0, 0.0), quantized(other, 255.0, 0.0), 0.0]
    });
    let read = |x: i64, y: i64| {
        let [luminance, chrominance, _] = stored.mirrored(x, y);
        PackedPixel {
            luminance,
            chrominance,
        }
    };
    Frame::from_fn(picture.size, |x, y| {
        let (column, row) = (i64::from(x), i64::from(y));
        let center = read(column, row);
        let cross = Cross {
            horizontal: Some([read(column + 1, row), read(column - 1, row)]),
            vertical: Some([read(column, row + 1), read(column, row - 1)]),
        };
        let missing = edge_directed(center, &cross);
        if stores_co(x, y) {
            [center.chrominance, center.luminance, missing]
        } else {
            [missing, center.luminance, center.chrominance]
        }
    })
}

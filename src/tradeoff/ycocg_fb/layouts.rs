//! Where a packed frame stores which chrominance: the checkerboard of the plugin, and others.
//!
//! One filter serves all of them, so that only the layout differs: the missing chrominance, as a ratio to
//! luminance, is the mean over all pixels within two columns and rows that store it. Their weights are those of
//! `ratio_adaptive` in the [ablation](super::ablation), divided by the fourth power of the distance.

use bevy_ycocg_fb::{
    PackedFormat,
    reference::{
        PackedPixel, decode, pack,
        reconstruct::{TOLERANCE, TOLERANCE_GROWTH},
        storage::stored,
    },
};

use super::{
    ablation::{difference, mean, ratio},
    frame::Frame,
};

/// The pixels that store Co; the others store Cg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Every second pixel.
    Checkerboard,
    /// Every second row.
    Rows,
    /// Every second block of 2 x 2 pixels.
    Blocks,
}

impl Layout {
    pub const ALL: [Self; 3] = [Self::Checkerboard, Self::Rows, Self::Blocks];

    /// Its name in the records.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Checkerboard => "checkerboard",
            Self::Rows => "rows",
            Self::Blocks => "blocks",
        }
    }

    /// Whether the pixel at a position stores Co.
    pub const fn stores_co(self, x: u32, y: u32) -> bool {
        let index = match self {
            Self::Checkerboard => x ^ y,
            Self::Rows => y,
            Self::Blocks => (x >> 1) ^ (y >> 1),
        };
        index & 1 == 0
    }

    /// Luminance and the chrominance that a pixel stores, not rounded.
    pub fn packed(self, color: [f32; 3], x: u32, y: u32) -> PackedPixel {
        // The plugin stores Co where x + y is even.
        pack(color, u32::from(!self.stores_co(x, y)), 0)
    }

    /// A scene-linear frame after it was packed in 16-bit floats and reconstructed.
    pub fn reconstructed(self, frame: &Frame) -> Frame {
        let [width, height] = frame.size;
        let packed: Vec<_> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| stored(self.packed(frame.at(x, y), x, y), PackedFormat::Float16))
            .collect();
        let at = |x: u32, y: u32| packed[(y * width + x) as usize];
        Frame::from_fn(frame.size, |x, y| {
            let is_co = self.stores_co(x, y);
            let range = |i: u32, side: u32| i.saturating_sub(2)..=(i + 2).min(side - 1);
            // Squared distance and pixel.
            let neighbors: Vec<_> = range(y, height)
                .flat_map(|row| range(x, width).map(move |column| (column, row)))
                .filter(|&(column, row)| self.stores_co(column, row) != is_co)
                .map(|(column, row)| {
                    let squared = column.abs_diff(x).pow(2) + row.abs_diff(y).pow(2);
                    (squared, at(column, row))
                })
                .collect();
            let center = at(x, y);
            // A block at a corner of the frame has no adjacent neighbour.
            let nearest = neighbors.iter().map(|(squared, _)| *squared).min();
            let smallest = neighbors
                .iter()
                .filter(|(squared, _)| Some(*squared) == nearest)
                .map(|(_, pixel)| difference(center, *pixel))
                .fold(f32::INFINITY, f32::min);
            let tolerance = TOLERANCE + TOLERANCE_GROWTH * smallest;
            let weighted = neighbors.iter().map(|(squared, pixel)| {
                let root = (tolerance + difference(center, *pixel)) * *squared as f32;
                (root.powi(-2), ratio(*pixel))
            });
            decode(center, center.luminance * mean(weighted), is_co)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the pixels store Co, and each pixel is beside one with the other chrominance.
    #[test]
    fn both_chrominances_are_everywhere() {
        for layout in Layout::ALL {
            let co = (0..64).filter(|i| layout.stores_co(i % 8, i / 8)).count();
            assert_eq!(co, 32, "{layout:?}");
            for (x, y) in (1..7).flat_map(|y| (1..7).map(move |x| (x, y))) {
                let is_other = |(x2, y2)| layout.stores_co(x2, y2) != layout.stores_co(x, y);
                let adjacent = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                assert!(adjacent.into_iter().any(is_other), "{layout:?}");
            }
        }
    }

    /// A frame of one hue and any luminance is exact but for rounding.
    #[test]
    fn one_hue_is_exact() {
        let frame = Frame::from_fn([19, 13], |x, y| {
            let light = 0.1 + ((7 * x + 13 * y) % 5) as f32;
            [0.9 * light, 0.5 * light, 0.2 * light]
        });
        for layout in Layout::ALL {
            let found = layout.reconstructed(&frame);
            let pairs = found.pixels.iter().zip(&frame.pixels);
            for (found, wanted) in pairs.flat_map(|(found, wanted)| found.iter().zip(wanted)) {
                let error = (found - wanted).abs() / wanted.max(1.0);
                assert!(error < 2e-3, "{layout:?}: {found} instead of {wanted}");
            }
        }
    }
}

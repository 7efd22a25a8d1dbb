//! The parts of an image by which encodings are compared before all of it is encoded.

use super::layout::mip_size;

/// Width and height of a window in pixels.
const SIDE: u32 = 64;

/// Number of windows of the largest level; each further one has half as many as the one before.
const COUNT: u32 = 32;

/// Pixels of a level.
pub(super) struct Window {
    pub(super) corner: [u32; 2],
    pub(super) size: [u32; 2],
}

impl Window {
    /// Windows all over each level of an image, or the whole of a level that has no more pixels than its windows.
    pub(super) fn of_levels(image_size: [u32; 2], levels: usize) -> Vec<Vec<Self>> {
        let of_level =
            |level: u32| Self::of_level(mip_size(image_size, level), (COUNT >> level).max(1));
        (0..levels as u32).map(of_level).collect()
    }

    fn of_level(size: [u32; 2], count: u32) -> Vec<Self> {
        let [width, height] = size.map(f64::from);
        if width * height <= f64::from(count * SIDE * SIDE) {
            return vec![Self {
                corner: [0, 0],
                size,
            }];
        }
        // Cells of a grid, each with a window somewhere in it.
        let most = size.map(|s| s.div_ceil(SIDE));
        let across = (f64::from(count) * width / height).sqrt().round() as u32;
        let columns = across
            .clamp(count.div_ceil(most[1]).min(most[0]), most[0])
            .max(1);
        let rows = (count / columns).clamp(1, most[1]);
        let window = |cell: u32| {
            let at = [cell % columns, cell / columns];
            // Positions that do not repeat from cell to cell, by the golden ratio.
            let place = [cell, cell / columns + 7 * cell]
                .map(|i| u64::from(i.wrapping_mul(0x9e37_79b9) >> 16));
            let window = [0, 1].map(|axis: usize| {
                let cells = u64::from([columns, rows][axis]);
                let [start, end] = [0, 1]
                    .map(|i| (u64::from(at[axis] + i) * u64::from(size[axis]) / cells) as u32);
                let side = SIDE.min(end - start);
                let free = u64::from(end - start - side + 1);
                [start + ((place[axis] * free) >> 16) as u32, side]
            });
            Self {
                corner: window.map(|[corner, _]| corner),
                size: window.map(|[_, side]| side),
            }
        };
        (0..columns * rows).map(window).collect()
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_inside_and_apart() {
        for size in [
            [2048, 2048],
            [16384, 1],
            [3, 9000],
            [1000, 600],
            [513, 4097],
            [7, 5],
        ] {
            for (level, windows) in Window::of_levels(size, 4).iter().enumerate() {
                let size = mip_size(size, level as u32);
                let pixels: usize = windows.iter().map(Window::pixels).sum();
                assert!(pixels <= (COUNT * SIDE * SIDE) as usize >> level);
                let all = size[0] as usize * size[1] as usize;
                assert!(pixels == all || 4 * pixels >= all.min(pixels * 4) && windows.len() > 1);
                for (i, a) in windows.iter().enumerate() {
                    let inside = (0..2).all(|c| a.corner[c] + a.size[c] <= size[c]);
                    assert!(inside && a.pixels() > 0, "{size:?}");
                    for b in &windows[..i] {
                        let is_apart = (0..2).any(|c| {
                            a.corner[c] + a.size[c] <= b.corner[c]
                                || b.corner[c] + b.size[c] <= a.corner[c]
                        });
                        assert!(is_apart, "{size:?}");
                    }
                }
            }
        }
    }
}

//! One channel of an image, and its downsampling.

use rayon::prelude::*;

/// A channel of real numbers, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Width and height in pixels, both at least 1.
    pub size: [u32; 2],
    /// `size[0] * size[1]` values.
    pub values: Vec<f32>,
}

impl Plane {
    /// Makes a plane by evaluating `value` at every pixel position.
    pub fn from_fn(size: [u32; 2], value: impl Fn(u32, u32) -> f32 + Sync) -> Self {
        Self::from_rows(size, |y, row| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = value(x as u32, y);
            }
        })
    }

    /// Makes a plane by filling its rows.
    pub fn from_rows(size: [u32; 2], fill: impl Fn(u32, &mut [f32]) + Sync) -> Self {
        let mut values = vec![0.0; size[0] as usize * size[1] as usize];
        values
            .par_chunks_mut(size[0] as usize)
            .enumerate()
            .for_each(|(y, row)| fill(y as u32, row));
        Self { size, values }
    }

    /// Iterates over all pixel positions, row by row.
    pub fn positions([width, height]: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }

    /// Returns the smallest and the largest value.
    pub fn bounds(&self) -> [f32; 2] {
        let start = [f32::INFINITY, f32::NEG_INFINITY];
        let values = self.values.iter();
        values.fold(start, |[min, max], v| [min.min(*v), max.max(*v)])
    }

    /// The value at a pixel. Outside of the plane it is that of the nearest pixel inside.
    pub fn clamped(&self, x: u32, y: u32) -> f32 {
        let x = x.min(self.size[0] - 1) as usize;
        let y = y.min(self.size[1] - 1) as usize;
        self.values[y * self.size[0] as usize + x]
    }

    /// The 2 x 2 pixels at `(2 x, 2 y)` as `[a, b, c, d]` of Eq. 3.15. Beyond the edges the
    /// outermost pixels are repeated.
    pub fn quad(&self, x: u32, y: u32) -> [f32; 4] {
        let (x, y) = (2 * x, 2 * y);
        [
            self.clamped(x, y),
            self.clamped(x + 1, y),
            self.clamped(x, y + 1),
            self.clamped(x + 1, y + 1),
        ]
    }

    /// The plane at half its size (rounded up), each value the mean of 2 x 2: chroma subsampling as
    /// in the thesis.
    ///
    /// The decoder repeats such a value over its 2 x 2 pixels, for which the mean has the least
    /// squared error.
    pub fn halved(&self) -> Self {
        let size = self.size.map(|s| s.div_ceil(2));
        Self::from_fn(size, |x, y| self.quad(x, y).iter().sum::<f32>() / 4.0)
    }

    /// The next mip at half the size (rounded down, at least 1), by an area-weighted box filter, so
    /// that odd sizes neither shift nor lose a row.
    pub fn next_mip(&self) -> Self {
        Self::next_mip_of(self.size, |i| self.values[i])
    }

    /// The next mip of a plane of the given size. `value` returns the value at an index into the
    /// plane.
    pub fn next_mip_of(size: [u32; 2], value: impl Fn(usize) -> f32 + Sync) -> Self {
        let (size, values) = next_mip_of(size, |i| [value(i)]);
        Self {
            size,
            values: values.into_flattened(),
        }
    }
}

/// The next mip of a level of several channels, and its size. `value` returns the channels at an index into
/// the level.
pub(super) fn next_mip_of<const CHANNELS: usize>(
    [width, height]: [u32; 2],
    value: impl Fn(usize) -> [f32; CHANNELS] + Sync,
) -> ([u32; 2], Vec<[f32; CHANNELS]>) {
    let [w, h] = [width, height].map(|s| (s / 2).max(1));
    let across: Vec<Cell> = (0..w).map(|x| Cell::new(x, width, w)).collect();
    let mut values = vec![[0.0; CHANNELS]; w as usize * h as usize];
    let rows = values.par_chunks_mut(w as usize).enumerate();
    rows.for_each(|(y, row)| {
        let cell = Cell::new(y as u32, height, h);
        let line = |y: usize| -> Vec<[f32; CHANNELS]> {
            let start = y * width as usize;
            let means = across.iter().map(|cell| cell.mean(|i| value(start + i)));
            means.collect()
        };
        let lines: Vec<_> = (cell.first..cell.first + cell.count).map(line).collect();
        for (x, mean) in row.iter_mut().enumerate() {
            *mean = cell.mean(|y| lines[y - cell.first][x]);
        }
    });
    ([w, h], values)
}

/// One of equal cells over samples.
struct Cell {
    /// The first sample that the cell overlaps.
    first: usize,
    /// Number of samples that it overlaps, at most three.
    count: usize,
    /// How much of each it overlaps.
    weights: [f64; 3],
    /// The sum of the weights.
    total: f64,
}

impl Cell {
    /// Cell `i` of `to` cells over `from` samples, which are at most three for each cell.
    fn new(i: u32, from: u32, to: u32) -> Self {
        let (i, from, to) = (u64::from(i), u64::from(from), u64::from(to));
        // The units are 1 / to of a sample, so that all positions are integers.
        let (start, end) = (i * from, (i + 1) * from);
        let (first, last) = (start / to, end.div_ceil(to));
        let weight = |at: u64| {
            let sample = first + at;
            let overlap = end
                .min((sample + 1) * to)
                .saturating_sub(start.max(sample * to));
            overlap as f64
        };
        Self {
            first: first as usize,
            count: (last - first) as usize,
            weights: [0, 1, 2].map(weight),
            total: from as f64,
        }
    }

    /// The mean of what `value` returns of the samples.
    fn mean<const CHANNELS: usize>(
        &self,
        value: impl Fn(usize) -> [f32; CHANNELS],
    ) -> [f32; CHANNELS] {
        let mut sum = [0.0; CHANNELS];
        for (at, weight) in self.weights.iter().enumerate().take(self.count) {
            let values = value(self.first + at);
            for (sum, value) in sum.iter_mut().zip(values) {
                *sum += f64::from(value) * weight;
            }
        }
        sum.map(|sum| (sum / self.total) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn mean(plane: &Plane) -> f64 {
        plane.values.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.values.len() as f64
    }

    proptest! {
        #[test]
        fn a_mip_keeps_the_mean_at_any_size(w in 1u32..20, h in 1u32..20, seed in 0u32..100) {
            let plane = Plane::from_fn([w, h], |x, y| {
                (x * 31 + y * 17 + seed).wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32
            });
            let mip = plane.next_mip();
            prop_assert_eq!(mip.size, [(w / 2).max(1), (h / 2).max(1)]);
            prop_assert!((mean(&mip) - mean(&plane)).abs() < 1e-6);
        }
    }

    #[test]
    fn three_pixels_become_one_by_area_and_halving_repeats_the_edge() {
        let plane = Plane {
            size: [3, 1],
            values: vec![0.0, 3.0, 6.0],
        };
        assert_eq!(plane.next_mip().values, [3.0]);
        assert_eq!(plane.halved().values, [1.5, 6.0]);
    }
}

//! One channel of an image, and how it is made smaller.

/// A channel of real numbers, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Width and height in pixels, both at least 1.
    pub size: [u32; 2],
    /// `size[0] * size[1]` values.
    pub values: Vec<f32>,
}

impl Plane {
    /// A plane whose values come from pixel positions.
    pub fn from_fn(size: [u32; 2], mut value: impl FnMut(u32, u32) -> f32) -> Self {
        let mut values = Vec::with_capacity(size[0] as usize * size[1] as usize);
        for y in 0..size[1] {
            for x in 0..size[0] {
                values.push(value(x, y));
            }
        }
        Self { size, values }
    }

    /// The value at a pixel; outside, the nearest pixel's.
    pub fn clamped(&self, x: u32, y: u32) -> f32 {
        let x = x.min(self.size[0] - 1) as usize;
        let y = y.min(self.size[1] - 1) as usize;
        self.values[y * self.size[0] as usize + x]
    }

    /// The 2 x 2 pixels at `(2 x, 2 y)`, edges repeated: `[a, b, c, d]` of Eq. 3.15.
    pub fn quad(&self, x: u32, y: u32) -> [f32; 4] {
        let (x, y) = (2 * x, 2 * y);
        [
            self.clamped(x, y),
            self.clamped(x + 1, y),
            self.clamped(x, y + 1),
            self.clamped(x + 1, y + 1),
        ]
    }

    /// The plane at half size (rounded up), each value the mean of 2 x 2: chroma subsampling.
    ///
    /// The decoder repeats a chroma value over its 2 x 2 pixels, for which the mean is best.
    pub fn halved(&self) -> Self {
        let size = self.size.map(|s| s.div_ceil(2));
        Self::from_fn(size, |x, y| self.quad(x, y).iter().sum::<f32>() / 4.0)
    }

    /// The next mip: half size (rounded down, at least 1), by an area-weighted box, so that odd
    /// sizes neither shift nor drop a row.
    pub fn next_mip(&self) -> Self {
        let [width, height] = self.size;
        let [w, h] = self.size.map(|s| (s / 2).max(1));
        let rows = Self::from_fn([w, height], |x, y| {
            box_mean(x, width, w, |i| self.values[(y * width + i) as usize])
        });
        Self::from_fn([w, h], |x, y| {
            box_mean(y, height, h, |i| rows.values[(i * w + x) as usize])
        })
    }
}

/// Mean of `value` over cell `i` of `to` equal cells over `from` samples.
fn box_mean(i: u32, from: u32, to: u32, value: impl Fn(u32) -> f32) -> f32 {
    let (from, to) = (u64::from(from), u64::from(to));
    // In units of 1 / to of a sample, so that all is integer.
    let (start, end) = (u64::from(i) * from, (u64::from(i) + 1) * from);
    let sum: f64 = (start / to..end.div_ceil(to))
        .map(|sample| {
            let overlap = end.min((sample + 1) * to) - start.max(sample * to);
            f64::from(value(sample as u32)) * overlap as f64
        })
        .sum();
    (sum / from as f64) as f32
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

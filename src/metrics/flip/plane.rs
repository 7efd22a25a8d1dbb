//! One channel of an image in `f32`, and separable filtering of it.

use rayon::prelude::*;

/// One channel, in raster order.
pub(super) struct Plane {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl Plane {
    /// Applies `f` to every value.
    pub fn map(&self, f: impl Fn(f32) -> f32 + Sync) -> Self {
        self.with_values(self.values.par_iter().map(|&v| f(v)).collect())
    }

    /// Value by value sum of two planes of the same size.
    pub fn sum(a: &Self, b: &Self) -> Self {
        a.zip(b, |a, b| a + b)
    }

    /// Value by value Euclidean norm of the vector (`x`, `y`).
    pub fn norm(x: &Self, y: &Self) -> Self {
        x.zip(y, |x, y| (x * x + y * y).sqrt())
    }

    /// Correlates every row with a kernel of odd length.
    pub fn filter_rows(&self, kernel: &[f32]) -> Self {
        let radius = kernel.len() / 2;
        self.rows(|y, out| {
            let row = &self.values[y * self.width..][..self.width];
            // A padded copy leaves the inner loop without bounds to clamp, so that it vectorises.
            let mut padded = Vec::with_capacity(row.len() + 2 * radius);
            padded.resize(radius, row[0]);
            padded.extend_from_slice(row);
            padded.resize(row.len() + 2 * radius, row[row.len() - 1]);
            for (tap, &weight) in kernel.iter().enumerate() {
                accumulate(out, weight, &padded[tap..]);
            }
        })
    }

    /// Correlates every column with a kernel of odd length.
    pub fn filter_columns(&self, kernel: &[f32]) -> Self {
        let radius = kernel.len() / 2;
        self.rows(|y, out| {
            for (tap, &weight) in kernel.iter().enumerate() {
                let source = (y + tap).saturating_sub(radius).min(self.height - 1);
                accumulate(out, weight, &self.values[source * self.width..]);
            }
        })
    }

    /// A plane of the same size whose rows, zero at first, are filled by `fill(y, row)`.
    fn rows(&self, fill: impl Fn(usize, &mut [f32]) + Sync) -> Self {
        let mut values = vec![0.0; self.values.len()];
        values
            .par_chunks_mut(self.width.max(1))
            .enumerate()
            .for_each(|(y, row)| fill(y, row));
        self.with_values(values)
    }

    fn zip(&self, other: &Self, f: impl Fn(f32, f32) -> f32 + Sync) -> Self {
        let pairs = self.values.par_iter().zip(&other.values);
        self.with_values(pairs.map(|(&a, &b)| f(a, b)).collect())
    }

    fn with_values(&self, values: Vec<f32>) -> Self {
        Self {
            width: self.width,
            height: self.height,
            values,
        }
    }
}

/// Adds `weight` times the first values of `source` to `out`.
fn accumulate(out: &mut [f32], weight: f32, source: &[f32]) {
    for (out, source) in out.iter_mut().zip(source) {
        *out += weight * source;
    }
}

//! Blocks between whose texels the texture unit interpolates, refined by the error of the pixels.
//!
//! Each pixel is a mean of four texels, so the errors of neighbouring texels partly cancel. The squared error of the
//! pixels is a quadratic form of the texels, whose matrix has eight neighbours in each row. Block by block, positions
//! and endpoints move to where that form is least while the other blocks stay.

use rayon::prelude::*;

use super::fit::{Channel, MOVES};
use crate::codec::interpolation::NormalEquations;

/// Number of times that all blocks are refined.
const SWEEPS: usize = 2;

/// Largest number of rounds of positions and endpoints of a block.
const MAX_ROUNDS: usize = 4;

/// The endpoints of each channel of a block, and the positions of its texels on the line between them, 0 to 3.
#[derive(Clone, Copy, PartialEq)]
pub struct Line<const C: usize> {
    pub ends: [[u8; 2]; C],
    pub positions: [u8; 16],
}

/// The texels of a level, and the pixels between them.
pub struct Interpolated<'a, const C: usize> {
    pub channels: &'a [Channel; C],
    /// The right sides are in the units of each channel.
    pub equations: NormalEquations<C>,
    /// Width and height in texels, without those of padding.
    pub size: [u32; 2],
    /// Number of blocks in a row.
    pub columns: usize,
}

/// The entries of a texel's row of the matrix for the texels around it.
type Stencil = [[f32; 3]; 3];

impl<const C: usize> Interpolated<'_, C> {
    /// Refines all blocks but those that are no line, whose texels stay as they are in `values`. `packed` makes a block
    /// of a line. The result does not depend on the number of threads.
    pub fn refine(
        &self,
        blocks: &mut [[u8; 8]],
        mut lines: Vec<Option<Line<C>>>,
        mut values: [Vec<f32>; C],
        packed: fn(Line<C>) -> [u8; 8],
    ) {
        // Blocks of one group do not touch.
        for group in (0..SWEEPS).flat_map(|_| 0..4) {
            let is_in_group =
                |b: &usize| b % self.columns % 2 == group % 2 && b / self.columns % 2 == group / 2;
            let group: Vec<usize> = (0..lines.len()).filter(is_in_group).collect();
            let refined = |b: &usize| lines[*b].map(|line| (*b, self.refined(*b, line, &values)));
            let found: Vec<(usize, Line<C>)> = group.par_iter().filter_map(refined).collect();
            for (block, line) in found {
                for (c, values) in values.iter_mut().enumerate() {
                    let palette = self.channels[c].palette(line.ends[c]);
                    for (i, position) in line.positions.iter().enumerate() {
                        if let Some(texel) = self.texel(block, i) {
                            values[texel] = palette[*position as usize];
                        }
                    }
                }
                lines[block] = Some(line);
            }
        }
        for (block, line) in blocks.iter_mut().zip(lines) {
            if let Some(line) = line {
                *block = packed(line);
            }
        }
    }

    fn position(&self, block: usize, i: usize) -> [usize; 2] {
        [
            block % self.columns * 4 + i % 4,
            block / self.columns * 4 + i / 4,
        ]
    }

    /// The index of a texel of a block, where it is not padding.
    fn texel(&self, block: usize, i: usize) -> Option<usize> {
        let [x, y] = self.position(block, i);
        let [width, height] = self.size.map(|s| s as usize);
        (x < width && y < height).then_some(y * width + x)
    }

    fn refined(&self, block: usize, mut line: Line<C>, values: &[Vec<f32>; C]) -> Line<C> {
        let width = self.size[0] as usize;
        let mut stencils: [Stencil; 16] = [[[0.0; 3]; 3]; 16];
        let mut right = [[0.0; 16]; C];
        for i in 0..16 {
            let Some(texel) = self.texel(block, i) else {
                continue;
            };
            let [x, y] = self.position(block, i);
            let [columns, rows] = &self.equations.matrices;
            let [across, down] = [columns.row(x), rows.row(y)];
            stencils[i] = down.map(|v| across.map(|u| u * v));
            for (right, all) in right.iter_mut().zip(&self.equations.right_sides) {
                right[i] = all[texel];
            }
            // What the texels of other blocks add is not left to this one.
            for (dx, dy) in NEIGHBOURS {
                let weight = stencils[i][dy][dx];
                if inside(i, dx, dy).is_none() && weight != 0.0 {
                    let beside = texel + dy * width + dx - width - 1;
                    for (right, values) in right.iter_mut().zip(values) {
                        right[i] -= weight * values[beside];
                    }
                }
            }
        }
        for _ in 0..MAX_ROUNDS {
            let before = line;
            self.place(&mut line, &stencils, &right);
            self.move_ends(&mut line, &stencils, &right);
            if line == before {
                break;
            }
        }
        line
    }

    /// Moves texels to their best position, one after the other.
    fn place(&self, line: &mut Line<C>, stencils: &[Stencil; 16], right: &[[f32; 16]; C]) {
        let palettes: [&[f32; 4]; C] =
            std::array::from_fn(|c| self.channels[c].palette(line.ends[c]));
        for i in 0..16 {
            let own = stencils[i][1][1];
            if own == 0.0 {
                continue;
            }
            let mut errors = [0.0; 4];
            for (palette, right) in palettes.iter().zip(right) {
                let mut residual = right[i];
                for (dx, dy) in NEIGHBOURS {
                    if let Some(j) = inside(i, dx, dy) {
                        residual -= stencils[i][dy][dx] * palette[line.positions[j] as usize];
                    }
                }
                for (error, value) in errors.iter_mut().zip(*palette) {
                    *error += value * (own * value - 2.0 * residual);
                }
            }
            for position in 0..4 {
                if errors[position] < errors[line.positions[i] as usize] {
                    line.positions[i] = position as u8;
                }
            }
        }
    }

    /// Moves the endpoints of each channel by steps, until none has less error.
    fn move_ends(&self, line: &mut Line<C>, stencils: &[Stencil; 16], right: &[[f32; 16]; C]) {
        // The quadratic form of the four values on the line.
        let mut matrix = [[0.0; 4]; 4];
        for i in 0..16 {
            let row = &mut matrix[line.positions[i] as usize];
            row[line.positions[i] as usize] += stencils[i][1][1];
            for (dx, dy) in NEIGHBOURS {
                if let Some(j) = inside(i, dx, dy) {
                    row[line.positions[j] as usize] += stencils[i][dy][dx];
                }
            }
        }
        for c in 0..C {
            let channel = &self.channels[c];
            let mut sums = [0.0; 4];
            for (position, right) in line.positions.iter().zip(&right[c]) {
                sums[*position as usize] += right;
            }
            let error = |values: &[f32; 4]| -> f32 {
                let of = |a: usize| {
                    let row: f32 = (0..4).map(|b| matrix[a][b] * values[b]).sum();
                    values[a] * (row - 2.0 * sums[a])
                };
                (0..4).map(of).sum()
            };
            let mut least = error(channel.palette(line.ends[c]));
            loop {
                let from = line.ends[c];
                for step in MOVES {
                    let Some(tried) = channel.moved(from, step) else {
                        continue;
                    };
                    let found = error(channel.palette(tried));
                    // A difference in the last bits is no improvement.
                    if found < least - 1e-6 * least.abs() {
                        (least, line.ends[c]) = (found, tried);
                    }
                }
                if line.ends[c] == from {
                    break;
                }
            }
        }
    }
}

/// Columns and rows of the texels around one, which is at 1 and 1.
const NEIGHBOURS: [(usize, usize); 8] = [
    (0, 0),
    (1, 0),
    (2, 0),
    (0, 1),
    (2, 1),
    (0, 2),
    (1, 2),
    (2, 2),
];

/// The place in its block of a neighbour of a texel, where it is in the same block.
fn inside(i: usize, dx: usize, dy: usize) -> Option<usize> {
    let (x, y) = ((i % 4 + dx).wrapping_sub(1), (i / 4 + dy).wrapping_sub(1));
    (x < 4 && y < 4).then_some(4 * y + x)
}

#[cfg(test)]
mod tests {
    use crate::codec::{
        blocks::{BlockFormat, ColorEncoder, Starts, decode_blocks, map_blocks},
        interpolation::{Axis, NormalEquations, fitted, interpolated},
        plane::Plane,
    };

    /// Also where the last blocks are not full.
    #[test]
    fn blocks_that_are_refined_have_less_error_between_their_texels() {
        for size in [[40, 32], [38, 30]] {
            let axes = size.map(|texels| Axis::stretched(texels * 4 / 3, texels));
            let pixels = [3, 5, 8].map(|c| {
                Plane::from_fn(axes.map(|axis| axis.pixels), |x, y| {
                    let hash = (x * 73 + y * 179 + c * 283) % 97;
                    (hash as f32 / 97.0 + ((x * c) as f32 / 40.0).sin().abs()) / 2.0
                })
            });
            let texels = pixels
                .each_ref()
                .map(|pixels| fitted(axes, 0.01, |i| pixels.values[i].clamp(0.0, 1.0)));
            let encoder = ColorEncoder::new(Starts::Two);
            let color = |(x, y)| [0, 1, 2].map(|c: usize| texels[c].clamped(x, y).clamp(0.0, 1.0));
            let mut blocks = map_blocks(size, |at| encoder.block(&at.map(color)).0);
            let error_of = |texel: &dyn Fn(usize, usize) -> f32| -> f64 {
                let of = |c: usize| -> f64 {
                    let count = (size[0] * size[1]) as usize;
                    let values = (0..count).map(|i| texel(c, i)).collect();
                    let read = interpolated(&Plane { size, values }, axes);
                    let pairs = read.values.iter().zip(&pixels[c].values);
                    pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum()
                };
                (0..3).map(of).sum()
            };
            // That of the smaller size alone, without blocks.
            let least = error_of(&|c, i| texels[c].values[i]);
            let error = |blocks: &[[u8; 8]]| {
                let decoded = decode_blocks(BlockFormat::Bc1, blocks.as_flattened(), size);
                error_of(&|c, i| decoded[i][c]) - least
            };
            let before = error(&blocks);
            let equations = NormalEquations::new(axes, |c, i| pixels[c].values[i]);
            encoder.refine(&mut blocks, equations, size);
            let after = error(&blocks);
            println!("{before} {after}");
            assert!(after < 0.98 * before);
        }
    }
}

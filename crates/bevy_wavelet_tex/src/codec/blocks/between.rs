//! Blocks whose texels are interpolated: refined by the error of the pixels between the texels.

use rayon::prelude::*;

use super::fit::{Channel, MOVES};

/// The products of the weights with which the pixels along an axis are interpolated between texels: of each texel
/// with itself, and with the one before.
pub struct Gram {
    pub own: Vec<f32>,
    pub beside: Vec<f32>,
}

impl Gram {
    pub fn new(taps: &[(u32, u32, f32)], texels: usize) -> Self {
        let mut own = vec![0.0; texels];
        let mut beside = vec![0.0; texels];
        for &(a, b, u) in taps {
            let (a, b) = (a as usize, b as usize);
            if a == b {
                own[a] += 1.0;
            } else {
                own[a] += (1.0 - u) * (1.0 - u);
                own[b] += u * u;
                beside[b] += u * (1.0 - u);
            }
        }
        Self { own, beside }
    }

    /// Of texels i and i + d - 1, d in 0..3.
    fn at(&self, i: i64, d: i64) -> f32 {
        let n = self.own.len() as i64;
        match d {
            0 if i >= 1 && i < n => self.beside[i as usize],
            1 if i < n => self.own[i as usize],
            2 if i + 1 < n => self.beside[(i + 1) as usize],
            _ => 0.0,
        }
    }
}

/// A block on a line.
#[derive(Clone, Copy, PartialEq)]
pub struct Line<const C: usize> {
    pub ends: [[u8; 2]; C],
    pub positions: [u8; 16],
}

/// Refines blocks. `wanted` is the sum over pixels of their values times the weight of each texel, in the units of the channels.
/// Blocks that are `None` are left, with the given values.
pub fn refine<const C: usize>(
    channels: &[Channel; C],
    grams: &[Gram; 2],
    wanted: &[Vec<f32>; C],
    lines: &mut [Option<Line<C>>],
    values: &mut [Vec<f32>; C],
    size: [usize; 2],
    columns: usize,
    sweeps: usize,
) {
    let rows = lines.len() / columns;
    let stencil = |x: usize, y: usize| -> [[f32; 3]; 3] {
        std::array::from_fn(|dy| {
            let v = grams[1].at(y as i64, dy as i64);
            std::array::from_fn(|dx| v * grams[0].at(x as i64, dx as i64))
        })
    };
    for _ in 0..sweeps {
        for color in 0..4 {
            let blocks: Vec<usize> = (0..lines.len())
                .filter(|b| (b % columns) % 2 == color % 2 && (b / columns) % 2 == color / 2)
                .filter(|b| lines[*b].is_some())
                .collect();
            let found: Vec<(usize, Line<C>)> = blocks
                .par_iter()
                .map(|&b| {
                    let (left, top) = (b % columns * 4, b / columns * 4);
                    let stencils: [[[f32; 3]; 3]; 16] = std::array::from_fn(|i| {
                        let (x, y) = (left + i % 4, top + i / 4);
                        if x < size[0] && y < size[1] { stencil(x, y) } else { [[0.0; 3]; 3] }
                    });
                    // What is wanted of the block, without what its neighbours give.
                    let rhs: [[f32; 16]; C] = std::array::from_fn(|c| {
                        std::array::from_fn(|i| {
                            let (x, y) = (left + i % 4, top + i / 4);
                            if x >= size[0] || y >= size[1] {
                                return 0.0;
                            }
                            let mut sum = wanted[c][y * size[0] + x];
                            for dy in 0..3 {
                                for dx in 0..3 {
                                    let (bx, by) = ((i % 4 + dx) as i64 - 1, (i / 4 + dy) as i64 - 1);
                                    if (0..4).contains(&bx) && (0..4).contains(&by) {
                                        continue;
                                    }
                                    let w = stencils[i][dy][dx];
                                    if w != 0.0 {
                                        let at = (y + dy - 1) * size[0] + x + dx - 1;
                                        sum -= w * values[c][at];
                                    }
                                }
                            }
                            sum
                        })
                    });
                    (b, refined(channels, &stencils, &rhs, lines[b].expect("a line")))
                })
                .collect();
            for (b, line) in found {
                let (left, top) = (b % columns * 4, b / columns * 4);
                for c in 0..C {
                    let palette = channels[c].palette(line.ends[c]);
                    for i in 0..16 {
                        let (x, y) = (left + i % 4, top + i / 4);
                        if x < size[0] && y < size[1] {
                            values[c][y * size[0] + x] = palette[line.positions[i] as usize];
                        }
                    }
                }
                lines[b] = Some(line);
            }
        }
    }
    let _ = rows;
}

fn refined<const C: usize>(
    channels: &[Channel; C],
    stencils: &[[[f32; 3]; 3]; 16],
    rhs: &[[f32; 16]; C],
    mut line: Line<C>,
) -> Line<C> {
    for _ in 0..4 {
        let before = line;
        // Positions.
        let palettes: [[f32; 4]; C] = std::array::from_fn(|c| *channels[c].palette(line.ends[c]));
        for _ in 0..2 {
            let mut changed = false;
            for i in 0..16 {
                let own = stencils[i][1][1];
                if own == 0.0 {
                    continue;
                }
                let mut of: [f32; 4] = [0.0; 4];
                for c in 0..C {
                    let mut around = rhs[c][i];
                    for dy in 0..3 {
                        for dx in 0..3 {
                            if dx == 1 && dy == 1 {
                                continue;
                            }
                            let (bx, by) = ((i % 4 + dx) as i64 - 1, (i / 4 + dy) as i64 - 1);
                            if (0..4).contains(&bx) && (0..4).contains(&by) {
                                let j = (by * 4 + bx) as usize;
                                around -= stencils[i][dy][dx] * palettes[c][line.positions[j] as usize];
                            }
                        }
                    }
                    for p in 0..4 {
                        let v = palettes[c][p];
                        of[p] += v * (own * v - 2.0 * around);
                    }
                }
                let mut best = line.positions[i] as usize;
                for p in 0..4 {
                    if of[p] < of[best] {
                        best = p;
                    }
                }
                if best != line.positions[i] as usize {
                    line.positions[i] = best as u8;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        // Ends.
        let mut q = [[0.0f32; 4]; 4];
        for i in 0..16 {
            for dy in 0..3 {
                for dx in 0..3 {
                    let (bx, by) = ((i % 4 + dx) as i64 - 1, (i / 4 + dy) as i64 - 1);
                    if (0..4).contains(&bx) && (0..4).contains(&by) {
                        let j = (by * 4 + bx) as usize;
                        q[line.positions[i] as usize][line.positions[j] as usize] += stencils[i][dy][dx];
                    }
                }
            }
        }
        for c in 0..C {
            let mut r = [0.0f32; 4];
            for i in 0..16 {
                r[line.positions[i] as usize] += rhs[c][i];
            }
            let error = |v: &[f32; 4]| -> f32 {
                let mut sum = 0.0;
                for a in 0..4 {
                    let mut row = -2.0 * r[a];
                    for b in 0..4 {
                        row += q[a][b] * v[b];
                    }
                    sum += v[a] * row;
                }
                sum
            };
            let last = channels[c].levels() as i16;
            let mut best = error(channels[c].palette(line.ends[c]));
            for _ in 0..8 {
                let from = line.ends[c];
                for step in MOVES {
                    let tried = [0, 1].map(|e| i16::from(from[e]) + step[e]);
                    if tried.iter().any(|e| *e < 0 || *e >= last) {
                        continue;
                    }
                    let tried = tried.map(|e| e as u8);
                    let found = error(channels[c].palette(tried));
                    if found < best - 1e-6 * best.abs() {
                        best = found;
                        line.ends[c] = tried;
                    }
                }
                if line.ends[c] == from {
                    break;
                }
            }
        }
        if line == before {
            break;
        }
    }
    line
}

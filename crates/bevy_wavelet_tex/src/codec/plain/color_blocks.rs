//! The blocks of colour.

use rayon::prelude::*;

use crate::codec::{
    blocks::{ColorEncoder, Starts},
    plane::Plane,
    settings::Effort,
};

type Block = [[f32; 3]; 16];

/// By default, this many blocks are encoded twice, or a quarter of them where that is more.
const TWICE: usize = 256;

/// BC1 blocks of texels, a plane for each channel. Blocks with the largest errors are encoded again with more effort, and
/// in the mode of three colours and black.
pub(super) fn bc1(texels: &[Plane], effort: Effort) -> Vec<u8> {
    let colors = blocks_of(texels);
    let encoder = ColorEncoder::new(Starts::One);
    let mut found: Vec<([u8; 8], f32)> = colors
        .par_iter()
        .map(|block| encoder.block(block))
        .collect();
    let again = match effort {
        Effort::Fast => 0,
        Effort::Default => found.len().div_ceil(4).max(TWICE),
        Effort::Best => found.len(),
    };
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|a, b| found[*b].1.total_cmp(&found[*a].1));
    order.truncate(again);
    let encoder = ColorEncoder::new(match effort {
        Effort::Best => Starts::Four,
        Effort::Fast | Effort::Default => Starts::Second,
    });
    let others: Vec<_> = order
        .par_iter()
        .map(|i| {
            let of_line = encoder.block(&colors[*i]);
            match encoder.block_with_black(&colors[*i]) {
                Some(with_black) if with_black.1 < of_line.1 => with_black,
                _ => of_line,
            }
        })
        .collect();
    for (i, other) in order.into_iter().zip(others) {
        if other.1 < found[i].1 {
            found[i] = other;
        }
    }
    found.into_iter().flat_map(|(block, _)| block).collect()
}

/// 4 x 4 colours for each block. Beyond the edges the outermost texels are repeated.
fn blocks_of(texels: &[Plane]) -> Vec<Block> {
    let [columns, rows] = texels[0].size.map(|s| s.div_ceil(4));
    let block = |block: u32| {
        std::array::from_fn(|i| {
            let x = block % columns * 4 + i as u32 % 4;
            let y = block / columns * 4 + i as u32 / 4;
            [0, 1, 2].map(|c: usize| texels[c].clamped(x, y))
        })
    };
    (0..columns * rows).into_par_iter().map(block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::blocks::{BlockFormat, decode_blocks};

    fn error(texels: &[[f32; 4]; 16], wanted: &Block) -> f32 {
        let of = |(texel, wanted): (&[f32; 4], &[f32; 3])| -> f32 {
            (0..3).map(|c| (texel[c] - wanted[c]).powi(2)).sum()
        };
        texels.iter().zip(wanted).map(of).sum()
    }

    #[test]
    fn more_effort_has_less_error() {
        let channel = |c: u32| {
            Plane::from_fn([32, 16], |x, y| {
                let hash = (x * 73 + y * 179 + c * 283) % 97;
                let smooth = (x * (c + 3) + y) as f32 / 200.0;
                if hash < 20 { 0.0 } else { smooth.min(1.0) }
            })
        };
        let texels = [channel(0), channel(1), channel(2)];
        let total = |effort| {
            let blocks = bc1(&texels, effort);
            let (blocks, _) = blocks.as_chunks::<8>();
            let colors = blocks_of(&texels);
            let errors = blocks.iter().zip(&colors);
            let of = |(block, wanted): (&[u8; 8], _)| {
                let texels = decode_blocks(BlockFormat::Bc1, block, [4, 4]);
                error(texels.first_chunk().expect("16 texels"), wanted)
            };
            errors.map(of).sum::<f32>()
        };
        let errors = [Effort::Fast, Effort::Default, Effort::Best].map(total);
        println!("{errors:?}");
        assert!(errors[1] < errors[0] && errors[2] < errors[1]);
    }
}

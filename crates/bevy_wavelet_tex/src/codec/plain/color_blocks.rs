//! The blocks of colour.

use rayon::prelude::*;

use crate::codec::{
    blocks::{BlockFormat, BlockQuality, ColorEncoder, Starts, decode_blocks, encode_bc1, is_dark},
    plane::Plane,
    settings::Effort,
};

type Block = [[f32; 3]; 16];

/// BC1 blocks of texels, a plane for each channel, in the mode of each that has the least error. The texels beyond
/// `visible` are those of padding.
pub(super) fn bc1(texels: &[Plane], visible: [u32; 2], effort: Effort) -> Vec<u8> {
    let blocks = blocks_of(texels);
    let starts = match effort {
        Effort::Fast => Starts::One,
        Effort::Default => Starts::Two,
        Effort::Best => Starts::Four,
    };
    let encoder = ColorEncoder::new(starts);
    let columns = texels[0].size[0].div_ceil(4) as usize;
    let encoded = |(i, colors): (usize, &Block)| {
        let on_line = encoder.block(colors);
        if effort == Effort::Fast {
            return on_line.0;
        }
        if effort == Effort::Default && !colors.iter().any(is_dark) {
            return on_line.0;
        }
        let with_black = encoder.block_with_black(colors, on_line.1);
        if effort == Effort::Default {
            let is_better = with_black.1 < on_line.1;
            return if is_better { with_black.0 } else { on_line.0 };
        }
        let left = [i % columns, i / columns].map(|block| 4 * block as u32);
        let visible = [0, 1].map(|axis: usize| visible[axis].saturating_sub(left[axis]));
        let error = |block: &[u8; 8]| error(block, colors, visible);
        let found = [on_line.0, with_black.0, by_library(colors)];
        let least = found
            .into_iter()
            .min_by(|a, b| error(a).total_cmp(&error(b)));
        least.expect("there are three")
    };
    let blocks: Vec<[u8; 8]> = blocks.par_iter().enumerate().map(encoded).collect();
    blocks.into_flattened()
}

/// The block of another encoder.
fn by_library(colors: &Block) -> [u8; 8] {
    let texels = colors.map(|[r, g, b]| [r, g, b, 1.0].map(|v| (v * 255.0 + 0.5) as u8));
    let block = encode_bc1(&texels, [4, 4], BlockQuality::High);
    *block.first_chunk().expect("a block")
}

/// The squared error of the visible texels of a block.
fn error(block: &[u8; 8], expected: &Block, [columns, rows]: [u32; 2]) -> f32 {
    let texels = decode_blocks(BlockFormat::Bc1, block, [4, 4]);
    let of = |i: usize| -> f32 {
        (0..3)
            .map(|c| (texels[i][c] - expected[i][c]).powi(2))
            .sum()
    };
    let is_visible = |i: &usize| ((*i % 4) as u32) < columns && ((*i / 4) as u32) < rows;
    (0..16).filter(is_visible).map(of).sum()
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

    #[test]
    fn more_effort_has_less_error() {
        let channel = |c: u32| {
            Plane::from_fn([80, 64], |x, y| {
                let hash = (x * 73 + y * 179 + c * 283) % 97;
                let smooth = (x * (c + 3) + y) as f32 / 200.0;
                if hash < 20 { 0.0 } else { smooth.min(1.0) }
            })
        };
        let texels = [channel(0), channel(1), channel(2)];
        let total = |effort| {
            let blocks = bc1(&texels, [80, 64], effort);
            let (blocks, _) = blocks.as_chunks::<8>();
            let colors = blocks_of(&texels);
            let errors = blocks.iter().zip(&colors);
            errors
                .map(|(block, expected)| error(block, expected, [4, 4]))
                .sum::<f32>()
        };
        let errors = [Effort::Fast, Effort::Default, Effort::Best].map(total);
        println!("{errors:?}");
        assert!(errors[1] < errors[0] && errors[2] < errors[1]);
    }
}

//! What lossless compression of frame buffers leaves, by two models.
//!
//! GPUs store blocks of pixels as differences to neighbours where that is smaller. Vendors document the principle and
//! the sizes of blocks, not the codes. So these are estimates: they compare formats, and predict no GPU.
//!
//! - **Delta blocks**, after AMD's delta colour compression (GPUOpen, *Getting the Most Out of Delta Color Compression*,
//!   2016): a block of 256 bytes stores its first pixel, and the difference of every other one to the pixel on its
//!   left (in the first column, above). All differences of a channel have as many bits as the largest of them needs.
//!   The block takes 64, 128 or 256 bytes.
//! - **Minimum trees**, after Arm's AFBC (US patent 8,542,939): of 4 x 4 pixels each channel stores the minimum, the
//!   differences of the minima of its four quadrants to that, and those of the pixels to their quadrant's, each group
//!   of four with as many bits as it needs. 16 of these take whole bytes each, and 16 bytes of header.
//!
//! Floats are compared by their bits, which have the order of their values.

use std::fmt::Write;

use super::{
    scenes::SCENES,
    settings::REFERENCE,
    surface::{Channel, Surface},
};
use crate::{
    record::{Measurement, Report},
    tradeoff::summary::means,
};

/// A model: its name in the records, and the bytes of a surface.
type Model = (&'static str, fn(&Surface) -> u64);

const STORED: &str = "stored";
const MODELS: [Model; 3] = [
    (STORED, Surface::bytes),
    ("delta blocks", delta_blocks),
    ("minimum trees", minimum_trees),
];

/// The rows of a scene: each surface with each model.
pub fn rows(scene: &str, surfaces: &[Surface]) -> Vec<Measurement> {
    let row = |surface: &Surface, (model, bytes): Model| Measurement {
        scene: scene.into(),
        setting: surface.name.clone(),
        reference: model.into(),
        bytes: Some(bytes(surface)),
        ..Measurement::default()
    };
    let rows = surfaces
        .iter()
        .flat_map(|surface| MODELS.map(|model| row(surface, model)));
    rows.collect()
}

/// The table with a title; empty where nothing was measured.
pub fn chapter(report: &Report) -> String {
    match table(report) {
        table if table.is_empty() => table,
        table => format!("\n### Lossless compression, by two models\n\n{table}"),
    }
}

/// The table of the pages: bytes a pixel, as means over the scenes. Empty where nothing was measured.
pub fn table(report: &Report) -> String {
    let rows = &report.measurements;
    let stored = || rows.iter().filter(|row| row.reference == STORED);
    let pixels = |scene: &str| {
        let row = stored().find(|row| (&*row.scene, &*row.setting) == (scene, REFERENCE));
        Some(row?.bytes? as f64 / 8.0)
    };
    let is_scene = |name: &str| SCENES.iter().any(|scene| scene.name == name);
    let columns = MODELS.map(|(model, _)| {
        let of_model = rows
            .iter()
            .filter(|row| row.reference == model && is_scene(&row.scene));
        means(of_model, |row| {
            Some(row.bytes? as f64 / pixels(&row.scene)?)
        })
    });
    let Some(first) = stored().next() else {
        return String::new();
    };
    let mut text = format!(
        "| bytes a pixel | {} |\n| --- | --- | --- | --- |\n",
        MODELS.map(|(model, _)| model).join(" | ")
    );
    for row in stored().filter(|row| row.scene == first.scene) {
        let cells = columns.each_ref().map(|column| {
            let bytes = column.get(&row.setting);
            bytes.map_or(String::new(), |bytes| format!("{bytes:.2}"))
        });
        let _ = writeln!(text, "| {} | {} |", row.setting, cells.join(" | "));
    }
    text
}

/// Bits of a field that says how many bits differences have.
const COUNT_BITS: u32 = 5;

fn delta_blocks(surface: &Surface) -> u64 {
    const BLOCK_BYTES: u32 = 256;
    let pixels = BLOCK_BYTES * 8 / surface.bits_per_pixel();
    let height = 1 << (pixels.ilog2() / 2);
    let width = pixels / height;
    let channel_bits = |channel: &Channel, [left, top]: [u32; 2]| {
        let at = |x: u32, y: u32| surface.value(channel, left + x, top + y);
        let difference = |i: u32| {
            let (x, y) = (i % width, i / width);
            let predicted = if x > 0 { at(x - 1, y) } else { at(x, y - 1) };
            signed_bits(at(x, y).wrapping_sub(predicted) as i32)
        };
        let most = (1..pixels).map(difference).max().unwrap_or(0);
        channel.bits + COUNT_BITS + (pixels - 1) * most
    };
    let bytes = |corner: [u32; 2]| {
        let channels = surface.channels.iter();
        let bits: u32 = channels.map(|channel| channel_bits(channel, corner)).sum();
        let bytes = bits.div_ceil(8).next_power_of_two();
        u64::from(bytes.clamp(BLOCK_BYTES / 4, BLOCK_BYTES))
    };
    surface.blocks([width, height]).map(bytes).sum()
}

fn minimum_trees(surface: &Surface) -> u64 {
    const SIDE: u32 = 16;
    const HEADER: u64 = 16;
    let raw = 16 * surface.bits_per_pixel();
    let channel_bits = |channel: &Channel, [left, top]: [u32; 2]| {
        let quadrants = [[0, 0], [2, 0], [0, 2], [2, 2]].map(|[x, y]| {
            [[0, 0], [1, 0], [0, 1], [1, 1]]
                .map(|[dx, dy]| surface.value(channel, left + x + dx, top + y + dy))
        });
        let groups: u32 = quadrants.into_iter().map(group_bits).sum();
        channel.bits + group_bits(quadrants.map(smallest)) + groups
    };
    let bytes = |[left, top]: [u32; 2]| {
        let tile = |i: u32| {
            let corner = [left + i % 4 * 4, top + i / 4 * 4];
            let channels = surface.channels.iter();
            let bits: u32 = channels.map(|channel| channel_bits(channel, corner)).sum();
            u64::from(bits.min(raw).div_ceil(8))
        };
        HEADER + (0..SIDE * SIDE / 16).map(tile).sum::<u64>()
    };
    surface.blocks([SIDE; 2]).map(bytes).sum()
}

fn smallest(values: [u32; 4]) -> u32 {
    values.into_iter().fold(u32::MAX, u32::min)
}

/// Bits of the differences of four values to their minimum: those of the three that are not 0, which one is, and how
/// many bits each of them has.
fn group_bits(values: [u32; 4]) -> u32 {
    let largest = values.into_iter().fold(0, u32::max);
    let bits = u32::BITS - (largest - smallest(values)).leading_zeros();
    COUNT_BITS + if bits == 0 { 0 } else { 2 + 3 * bits }
}

/// Bits of a number of two's complement, none for 0.
fn signed_bits(value: i32) -> u32 {
    match value {
        0 => 0,
        _ => 1 + u32::BITS - (value ^ (value >> 31)).leading_zeros(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four equal channels of 8 bits.
    fn surface(size: [u32; 2], value: impl Fn(u32, u32) -> u32) -> Surface {
        Surface::new("test".into(), size, &[8; 4], |x, y| vec![value(x, y); 4])
    }

    #[test]
    fn bits_of_differences() {
        for (value, bits) in [(0, 0), (1, 2), (-1, 1), (3, 3), (-4, 3), (4, 4), (255, 9)] {
            assert_eq!(signed_bits(value), bits, "{value}");
        }
        assert_eq!(group_bits([7; 4]), COUNT_BITS);
        assert_eq!(group_bits([7, 8, 9, 10]), COUNT_BITS + 2 + 3 * 2);
    }

    #[test]
    fn a_flat_surface_is_smallest_and_noise_is_stored_as_it_is() {
        let flat = surface([64, 64], |_, _| 17);
        assert_eq!(delta_blocks(&flat), flat.bytes() / 4);
        // Of each channel of 4 x 4 pixels the minimum and five counts of bits, 17 bytes in all.
        assert_eq!(minimum_trees(&flat), 16 * (16 + 16 * 17));
        let noise = surface([64, 64], |x, y| {
            ((x * 0x9e37) ^ (y * 0x79b9)).wrapping_mul(0x85eb_ca6b) >> 24
        });
        assert_eq!(delta_blocks(&noise), noise.bytes());
        let range = noise.bytes() * 9 / 10..=noise.bytes() + 16 * 16;
        assert!(range.contains(&minimum_trees(&noise)));
    }

    /// Blocks of 8 x 8 pixels; a slope of 1 is a difference of two bits.
    #[test]
    fn a_slope_takes_the_bits_of_its_differences() {
        let slope = surface([64, 64], |x, _| x);
        let bits: u32 = 4 * (8 + COUNT_BITS + 63 * 2);
        assert!((64 * 8..128 * 8).contains(&bits));
        assert_eq!(delta_blocks(&slope), 64 * 128);
    }

    #[test]
    fn the_table_has_means_in_bytes_a_pixel() {
        let names = [SCENES[0].name, SCENES[1].name];
        let surfaces = [REFERENCE, "half"].map(|name| {
            let bits: &[u32] = if name == REFERENCE {
                &[16; 4]
            } else {
                &[16; 2]
            };
            Surface::new(name.into(), [16, 16], bits, |_, _| vec![9; bits.len()])
        });
        let report = Report {
            measurements: names
                .iter()
                .flat_map(|name| rows(name, &surfaces))
                .collect(),
            ..Report::default()
        };
        let text = table(&report);
        assert!(text.contains("| rgba16float | 8.00 | 2.00 |"), "{text}");
        assert!(text.contains("| half | 4.00 | 1.00 |"), "{text}");
        assert_eq!(table(&Report::default()), "");
    }
}

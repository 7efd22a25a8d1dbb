//! Colours between the GPU and its memory, in bytes a pixel, from a model.
//!
//! A layer is a surface that covers every sample of the pixel. An opaque one writes its colour, a blended one reads
//! what is there and writes. Without lossless compression each sample is written; with it, samples of one colour are
//! stored once, which is the best case: at the edges of triangles it is less. No cache keeps a layer until the next
//! one, as no cache holds a whole frame.
//!
//! Once a frame, samples are resolved to a pixel, and the packed texture is read and written as Bevy's HDR texture;
//! what neighbouring pixels read comes from the cache. Passes after that are the same for both.
//!
//! [`thesis_table`] is table 4.1 of the thesis by the same model, which counts depth too.

use std::fmt::Write;

/// A format of a camera's colours.
struct Format {
    name: &'static str,
    /// Bytes of a sample.
    bytes: u32,
    is_packed: bool,
}

const FORMATS: [Format; 6] = [
    Format::new("Bevy's `Rgba16Float` (`Hdr`)", BEVYS, false),
    Format::new("`Float16` (default)", 4, true),
    Format::new("`Rg11b10Ufloat`", 4, false),
    Format::new("`Float32`", 8, true),
    Format::new("Bevy's `Rgba8UnormSrgb` (without `Hdr`)", LDR, false),
    Format::new("`Unorm8`", 2, true),
];
/// Bytes of a pixel of Bevy's HDR texture.
const BEVYS: u32 = 8;
/// Bytes of a pixel of Bevy's 8-bit texture.
const LDR: u32 = 4;
const SAMPLES: [u32; 3] = [1, 4, 8];

impl Format {
    const fn new(name: &'static str, bytes: u32, is_packed: bool) -> Self {
        Self {
            name,
            bytes,
            is_packed,
        }
    }

    /// Bytes of a pixel with so many samples that are stored.
    const fn layer(&self, stored: u32, is_blended: bool) -> u32 {
        self.bytes * stored * if is_blended { 2 } else { 1 }
    }

    /// Bytes of a pixel once a frame, with so many samples of which so many are stored.
    const fn once(&self, samples: u32, stored: u32) -> u32 {
        let resolve = if samples > 1 {
            self.bytes * stored + self.bytes
        } else {
            0
        };
        let unpack = if self.is_packed {
            self.bytes + self.output()
        } else {
            0
        };
        resolve + unpack
    }

    /// What `Unorm8` is resolved to is never HDR.
    const fn output(&self) -> u32 {
        if self.bytes < LDR { LDR } else { BEVYS }
    }
}

/// The table of the page of `bevy_ycocg_fb`: without compression / with it.
pub fn table() -> String {
    let mut text = "| format | samples | opaque layer | blended layer | once a frame |\n\
                    | --- | --- | --- | --- | --- |\n"
        .to_string();
    for samples in SAMPLES {
        for format in &FORMATS {
            let cell = |bytes: &dyn Fn(u32) -> u32| match samples {
                1 => bytes(1).to_string(),
                _ => format!("{} / {}", bytes(samples), bytes(1)),
            };
            let _ = writeln!(
                text,
                "| {} | {samples} | {} | {} | {} |",
                format.name,
                cell(&|stored| format.layer(stored, false)),
                cell(&|stored| format.layer(stored, true)),
                cell(&|stored| format.once(samples, stored)),
            );
        }
    }
    text
}

/// Bytes of a sample of depth.
const DEPTH: u32 = 4;

/// Bytes of a fragment that passes the depth test: it reads depth, writes depth and colour, and a blended one reads
/// the colour too (thesis 4.8).
const fn fragment(color: u32, is_blended: bool) -> u32 {
    2 * DEPTH + color * if is_blended { 2 } else { 1 }
}

/// Table 4.1 of the thesis, computed, for channels of 8, 16 and 32 bits: four of them beside the two of a packed
/// format, with depth.
pub fn thesis_table() -> String {
    let mut text = "| bits of a channel | bytes of a sample | opaque fragment | blended fragment | resolve |\n\
                    | --- | --- | --- | --- | --- |\n"
        .to_string();
    for bits in [8, 16, 32] {
        let cell = |bytes: &dyn Fn(u32) -> u32| {
            let [bevys, packed] = [4, 2].map(|channels| bytes(channels * bits / 8));
            let saved = 100.0 * (1.0 - f64::from(packed) / f64::from(bevys));
            format!("{bevys} -> {packed} ({saved:.0}% less)")
        };
        let cells = [
            cell(&|color| color + DEPTH),
            cell(&|color| fragment(color, false)),
            cell(&|color| fragment(color, true)),
            // It reads the colour and writes that of a display.
            cell(&|color| color + LDR),
        ];
        let _ = writeln!(text, "| {bits} | {} |", cells.join(" | "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The figures in the text of section 4.8.
    #[test]
    fn the_thesis_saves_a_quarter_a_third_and_63_megabytes() {
        let share =
            |is_blended| f64::from(fragment(4, is_blended)) / f64::from(fragment(8, is_blended));
        assert_eq!(share(false), 0.75);
        assert!((share(true) - 2.0 / 3.0).abs() < 1e-9);
        let samples = f64::from(1920 * 1080 * 8) / f64::from(1 << 20);
        let megabytes = |color: u32| (samples * f64::from(color + DEPTH)).floor();
        assert_eq!([8, 4].map(megabytes), [189.0, 126.0]);
        let text = thesis_table();
        assert!(
            text.contains(
                "| 16 | 12 -> 8 (33% less) | 16 -> 12 (25% less) | 24 -> 16 (33% less) |"
            ),
            "{text}"
        );
    }

    #[test]
    fn packed_layers_take_half_and_the_frame_is_paid_once() {
        let [bevy, packed, ..] = &FORMATS;
        for is_blended in [false, true] {
            assert_eq!(2 * packed.layer(4, is_blended), bevy.layer(4, is_blended));
        }
        // Without multisampling three opaque layers pay for the resolve, with four samples it pays for itself.
        assert_eq!(
            packed.once(1, 1),
            3 * (bevy.layer(1, false) - packed.layer(1, false))
        );
        assert!(packed.once(4, 4) < bevy.once(4, 4));
        assert_eq!(packed.once(4, 1) - bevy.once(4, 1), 4);
    }
}

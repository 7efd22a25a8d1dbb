//! What is measured: every way to store a frame, by its name in the records.

use bevy::prelude::*;
use bevy_ycocg_fb::{
    FrameBufferQuality, PackedFormat, Reconstruction, YCoCgFrameBuffer,
    reference::{PackedImage, color::linear_from_srgb, color::srgb_from_linear},
};

use super::frame::Frame;

/// A representation of a frame in memory.
#[derive(Clone, Copy)]
pub struct Setting {
    /// Its name in the records.
    pub name: &'static str,
    /// Bytes of colour a pixel, without what it is resolved to.
    pub bytes_per_pixel: f64,
    /// Texture fetches of the pass that reads it, a pixel.
    pub fetches: f64,
    pub picture: Picture,
}

#[derive(Clone, Copy)]
pub enum Picture {
    /// On the CPU, from what a display shows, sRGB-encoded but not rounded, to another.
    Display(fn(&Frame) -> Frame),
    /// By a camera of the plugin.
    Camera(FrameBufferQuality),
}

/// The frame as it is: what all others are compared with.
pub const REFERENCE: &str = "rgba16float";

/// The settings in the order of the report.
pub fn settings() -> Vec<Setting> {
    let display = |name, fetches, picture| Setting {
        name,
        bytes_per_pixel: 2.0,
        fetches,
        picture: Picture::Display(picture),
    };
    let camera = |name, bytes_per_pixel, fetches, quality| Setting {
        name,
        bytes_per_pixel,
        fetches,
        picture: Picture::Camera(quality),
    };
    let float16 = |name, fetches, reconstruction| {
        let packed = YCoCgFrameBuffer {
            reconstruction,
            ..default()
        };
        camera(name, 4.0, fetches, packed.into())
    };
    let float32 = YCoCgFrameBuffer::with_format(PackedFormat::Float32);
    vec![
        float16("nearest", 2.0, Reconstruction::Nearest),
        float16("bilinear", 3.0, Reconstruction::Bilinear),
        float16("edge_directed", 3.0, Reconstruction::EdgeDirected),
        float16("guided", 3.0, Reconstruction::Guided),
        float16("default", 4.0, Reconstruction::default()),
        float16("quad", 1.0, Reconstruction::Quad),
        camera("float32_default", 8.0, 4.0, float32.into()),
        camera("rg11b10ufloat", 4.0, 1.0, FrameBufferQuality::Compact),
        display("unorm8_edge_directed", 3.0, |f| {
            unorm8(f, Reconstruction::EdgeDirected)
        }),
        display("unorm8_default", 4.0, |f| {
            unorm8(f, Reconstruction::default())
        }),
        display("rgb565", 1.0, rgb565),
    ]
}

/// The 8-bit format takes display-linear values.
fn unorm8(encoded: &Frame, filter: Reconstruction) -> Frame {
    let linear = encoded.map(linear_from_srgb);
    let packed = PackedImage::pack(&linear.pixels, linear.size, [0; 2], PackedFormat::Unorm8);
    let unpacked = Frame {
        size: linear.size,
        pixels: packed.unpack(filter),
    };
    unpacked.map(srgb_from_linear)
}

/// 5 bits of red, 6 of green and 5 of blue, with an ordered dither.
fn rgb565(picture: &Frame) -> Frame {
    Frame::from_fn(picture.size, |x, y| {
        let [r, g, b] = picture.at(x, y);
        [(r, 31.0), (g, 63.0), (b, 31.0)].map(|(value, levels)| {
            (value * levels + threshold(x, y))
                .round()
                .clamp(0.0, levels)
                / levels
        })
    })
}

/// An 8 x 8 threshold matrix (B. E. Bayer, 1973) at a pixel: -0.5 to 0.5, with a mean of 0.
fn threshold(x: u32, y: u32) -> f32 {
    // Bits of x ^ y and y, the lowest first, interleaved to the highest.
    let rank = (0..3).fold(0, |rank, bit| {
        let (a, b) = ((x ^ y) >> bit & 1, y >> bit & 1);
        rank << 2 | a << 1 | b
    });
    (rank as f32 + 0.5) / 64.0 - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_threshold_of_the_matrix_occurs_once() {
        let mut ranks: Vec<i32> = (0..64)
            .map(|i| ((threshold(i % 8, i / 8) + 0.5) * 64.0) as i32)
            .collect();
        ranks.sort_unstable();
        assert!(ranks.into_iter().eq(0..64));
    }

    #[test]
    fn rgb565_keeps_the_mean_of_a_flat_colour() {
        let color = [0.8, 0.35, 0.1];
        let stored = rgb565(&Frame::from_fn([64, 48], |_, _| color));
        let count = stored.pixels.len() as f32;
        for c in 0..3 {
            let mean = stored.pixels.iter().map(|p| p[c]).sum::<f32>() / count;
            assert!((mean - color[c]).abs() < 3e-3, "{mean}");
        }
    }
}

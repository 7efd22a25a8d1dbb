//! What is measured: every way to store a frame, by its name in the records.

use bevy::prelude::*;
use bevy_ycocg_fb::{
    FrameBufferQuality, PackedFormat, Reconstruction, YCoCgFrameBuffer,
    reference::{
        PackedImage, color::linear_from_srgb, color::srgb_from_linear, rg11b10ufloat::dithered,
    },
};

use super::{
    ablation,
    alternatives::{
        bayer::bayer, fewer_pixels, rgb_checkerboard::rgb_checkerboard, rgb565::rgb565,
        y8co4cg4::y8co4cg4,
    },
    frame::Frame,
    layouts::Layout,
};

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
    /// On the CPU, from the scene-linear frame of Bevy's camera to another.
    SceneLinear(fn(&Frame) -> Frame),
    /// On the CPU, from what a display shows, sRGB-encoded but not rounded, to another.
    Display(fn(&Frame) -> Frame),
    /// By a camera of the plugin, and where there is no scene on the CPU.
    Camera {
        quality: FrameBufferQuality,
        /// From a scene-linear frame to another.
        store: fn(&Frame) -> Frame,
    },
}

/// The frame as it is: what all others are compared with.
pub const REFERENCE: &str = "rgba16float";

/// The settings in the order of the report; the steps of the ablation follow them.
pub fn settings() -> Vec<Setting> {
    let display = |name, bytes_per_pixel, fetches, picture| Setting {
        name,
        bytes_per_pixel,
        fetches,
        picture: Picture::Display(picture),
    };
    let camera = |name, fetches, reconstruction, store| Setting {
        name,
        bytes_per_pixel: 4.0,
        fetches,
        picture: Picture::Camera {
            quality: FrameBufferQuality::Packed(YCoCgFrameBuffer {
                reconstruction,
                ..default()
            }),
            store,
        },
    };
    let mut settings = vec![
        camera("nearest", 2.0, Reconstruction::Nearest, |f| {
            float16(f, Reconstruction::Nearest)
        }),
        camera("bilinear", 3.0, Reconstruction::Bilinear, |f| {
            float16(f, Reconstruction::Bilinear)
        }),
        camera("edge_directed", 3.0, Reconstruction::EdgeDirected, |f| {
            float16(f, Reconstruction::EdgeDirected)
        }),
        camera("guided", 3.0, Reconstruction::Guided, |f| {
            float16(f, Reconstruction::Guided)
        }),
        camera("default", 4.0, Reconstruction::default(), |f| {
            float16(f, Reconstruction::default())
        }),
        camera("quad", 1.0, Reconstruction::Quad, |f| {
            float16(f, Reconstruction::Quad)
        }),
        Setting {
            name: "float32_default",
            bytes_per_pixel: 8.0,
            fetches: 4.0,
            picture: Picture::Camera {
                quality: YCoCgFrameBuffer::with_format(PackedFormat::Float32).into(),
                store: |f| stored(f, PackedFormat::Float32, Reconstruction::default()),
            },
        },
        Setting {
            name: "rg11b10ufloat",
            bytes_per_pixel: 4.0,
            fetches: 1.0,
            picture: Picture::Camera {
                quality: FrameBufferQuality::Compact,
                store: |f| Frame::from_fn(f.size, |x, y| dithered(f.at(x, y), x, y)),
            },
        },
        display("unorm8_edge_directed", 2.0, 3.0, |f| {
            unorm8(f, Reconstruction::EdgeDirected)
        }),
        display("unorm8_default", 2.0, 4.0, |f| {
            unorm8(f, Reconstruction::default())
        }),
        display("two_thirds_bilinear", 2.0, 1.0, fewer_pixels::bilinear),
        display("two_thirds_bicubic", 2.0, 16.0, fewer_pixels::bicubic),
        display("rgb565", 2.0, 1.0, rgb565),
        display("y8co4cg4", 2.0, 1.0, y8co4cg4),
        display("bayer", 1.0, 13.0, bayer),
        display("rgb_checkerboard", 2.0, 5.0, rgb_checkerboard),
    ];
    settings.extend(steps());
    settings.extend(layouts());
    settings
}

fn steps() -> impl Iterator<Item = Setting> {
    const PICTURES: [fn(&Frame) -> Frame; ablation::STEPS.len()] = [
        |f| step(f, 0),
        |f| step(f, 1),
        |f| step(f, 2),
        |f| step(f, 3),
        |f| step(f, 4),
    ];
    let named = ablation::STEPS.iter().zip(PICTURES);
    named.map(|(&(name, _), picture)| Setting {
        name,
        bytes_per_pixel: 4.0,
        fetches: 3.0,
        picture: Picture::SceneLinear(picture),
    })
}

/// Every pixel within two columns and rows is fetched.
fn layouts() -> impl Iterator<Item = Setting> {
    let picture: [(_, fn(&Frame) -> Frame); 3] = [
        ("layout_checkerboard", |f| {
            Layout::Checkerboard.reconstructed(f)
        }),
        ("layout_rows", |f| Layout::Rows.reconstructed(f)),
        ("layout_blocks", |f| Layout::Blocks.reconstructed(f)),
    ];
    picture.into_iter().map(|(name, picture)| Setting {
        name,
        bytes_per_pixel: 4.0,
        fetches: 25.0,
        picture: Picture::SceneLinear(picture),
    })
}

fn step(frame: &Frame, index: usize) -> Frame {
    let packed = PackedImage::pack(&frame.pixels, frame.size, [0; 2], PackedFormat::Float16);
    Frame {
        size: frame.size,
        pixels: ablation::unpack(&packed, ablation::STEPS[index].1),
    }
}

fn float16(frame: &Frame, filter: Reconstruction) -> Frame {
    stored(frame, PackedFormat::Float16, filter)
}

/// Packs and unpacks in the units of the format.
fn stored(frame: &Frame, format: PackedFormat, filter: Reconstruction) -> Frame {
    let packed = PackedImage::pack(&frame.pixels, frame.size, [0; 2], format);
    Frame {
        size: frame.size,
        pixels: packed.unpack(filter),
    }
}

/// The 8-bit format takes display-linear values.
fn unorm8(encoded: &Frame, filter: Reconstruction) -> Frame {
    let linear = encoded.map(linear_from_srgb);
    stored(&linear, PackedFormat::Unorm8, filter).map(srgb_from_linear)
}

//! The study of `bevy_ycocg_fb`: how close each way to store a frame comes to Bevy's own
//! `Rgba16Float` camera, on scenes that are hard in different ways.
//!
//! The frame of Bevy's camera is captured before tone mapping and stored and loaded on the CPU,
//! with the [reference](bevy_ycocg_fb::reference) of the plugin; then both
//! are tone-mapped as Bevy does by default and compared in 8 bits. The pictures of packed cameras
//! ([`Picture::Camera`]) are rendered by the plugin and tone-mapped by Bevy, and compared with Bevy's
//! own camera treated so.
//!
//! `bytes` are those of colour at one sample a pixel, as stored, without what it is resolved to;
//! `fetches` are those of the pass that reads it.

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::Rgba32FImage,
    metrics::compare,
    scenes::ycocg_fb::scenes::{SCENES, TestScene},
};
use bevy_ycocg_fb::{
    FrameBufferQuality, PackedFormat, Reconstruction, YCoCgFrameBuffer,
    reference::{
        PackedImage,
        pack::{linear_from_srgb, srgb_from_linear},
    },
};
use image::{Rgb, RgbImage};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use crate::{
    plan::Plan,
    record::{PictureRow, Report, TimeRow},
    run::{Study, TradeoffError},
    summary::{Choice, Need, Quantity, Source, Summary, means},
    ycocg_fb::{
        cost::NO_OVERDRAW,
        display::{ToneMap, display_frames, hdr_frame},
    },
};

pub mod cost;

pub mod display;

/// The study.
pub struct YCoCgFb;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    pub pictures: Vec<PictureRow>,
    pub times: Vec<TimeRow>,
}

impl Study for YCoCgFb {
    const NAME: &'static str = "ycocg_fb";
    type Rows = Rows;

    fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report<Rows>, TradeoffError> {
        let Some(size) = plan.frame else {
            return Ok(Report::<Rows>::default());
        };
        let settings = settings();
        progress.set_length((SCENES.len() + cost::STEPS) as u64);

        progress.set_message("tone mapping");
        let tone_map = ToneMap::capture()?;
        let mut report = Report {
            adapter: tone_map.adapter().clone(),
            ..Report::<Rows>::default()
        };
        for scene in &SCENES {
            progress.set_message(scene.name);
            let rows = scene_rows(scene, size, &settings, &tone_map)?;
            report.rows.pictures.extend(rows);
            progress.inc(1);
        }
        report.rows.times = cost::rows(plan, progress)?;
        Ok(report)
    }

    /// Mean PSNR over the rendered scenes, none above that of rounding to 8 bits, and the time of a frame
    /// with nothing in it, which is the worst case: nothing is saved, and the resolve is paid.
    fn summary(rows: &Rows) -> Summary {
        let is_scene = |name: &str| SCENES.iter().any(|scene| scene.name == name);
        let pictures = rows.pictures.iter().filter(|row| is_scene(&row.scene));
        let quality = means(pictures.map(|row| {
            let psnr = row.error.psnr_db.unwrap_or(f64::INFINITY);
            (&row.setting, Some(psnr.min(PSNR_OF_ROUNDING)))
        }));
        let times = rows.times.iter().filter(|row| row.scene == NO_OVERDRAW);
        let times = means(times.map(|row| (&row.setting, row.times.frame_ms())));
        let bevy = times.get(REFERENCE).copied();
        let choices = times.iter().filter_map(|(name, time)| {
            let (setting, source) = match *name {
                "packed_hdr" => ("default", Source::Ours),
                "rg11b10ufloat" => ("rg11b10ufloat", Source::Ours),
                name => match name.strip_prefix("packed_hdr ") {
                    Some(filter) => (filter, Source::Ours),
                    None => (name, Source::Baseline),
                },
            };
            Some(Choice {
                name: setting.into(),
                error: *quality.get(setting)?,
                cost: time / bevy?,
                source,
            })
        });
        Summary {
            title: "bevy_ycocg_fb: quality against time, half the memory of Rgba16Float".into(),
            error: Quantity::more("mean PSNR", "dB", 1),
            cost: Quantity::less("time of an empty frame", "of Bevy's own", 2),
            choices: choices.collect(),
            needs: vec![Need::LeastCost, Need::Error(45.0), Need::LeastError],
        }
    }
}

/// The rows of a scene: all settings, the reference first.
pub fn scene_rows(
    scene: &TestScene,
    size: [u32; 2],
    settings: &[Setting],
    tone_map: &ToneMap,
) -> Result<Vec<PictureRow>, TradeoffError> {
    let frame = Frame::from(&hdr_frame(scene, size)?);
    let display = tone_map.display(&frame);
    let reference = display.to_rgb8();
    let itself = Setting {
        name: REFERENCE,
        bytes_per_pixel: 8.0,
        fetches: 1.0,
        picture: Picture::Display(Frame::clone),
    };
    let mut rows = vec![row(scene.name, &itself, &reference, &reference)?];
    let mut cameras = Vec::new();
    for setting in settings {
        match setting.picture {
            Picture::Camera(quality) => cameras.push((setting, quality)),
            Picture::Display(store) => {
                let picture = store(&display).to_rgb8();
                rows.push(row(scene.name, setting, &reference, &picture)?);
            }
        }
    }
    let qualities: Vec<_> = cameras.iter().map(|(_, quality)| *quality).collect();
    let (bevy, pictures) = display_frames(scene, size, &qualities)?;
    for ((setting, _), picture) in cameras.iter().zip(&pictures) {
        rows.push(row(scene.name, setting, &bevy, picture)?);
    }
    Ok(rows)
}

fn row(
    scene: &str,
    setting: &Setting,
    reference: &RgbImage,
    picture: &RgbImage,
) -> Result<PictureRow, TradeoffError> {
    let pixels = f64::from(reference.width()) * f64::from(reference.height());
    Ok(PictureRow {
        scene: scene.into(),
        setting: setting.name.into(),
        reference: REFERENCE.into(),
        bytes: Some((pixels * setting.bytes_per_pixel) as u64),
        fetches: setting.fetches,
        error: compare(reference, picture)?.into(),
        cpu_ms: None,
    })
}

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

/// A picture of floats: scene-linear as a camera draws it, or sRGB-encoded as a display shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Red, green and blue, row after row from the top left.
    pub pixels: Vec<[f32; 3]>,
}

impl Frame {
    /// A picture whose colours come from pixel positions.
    pub fn from_fn(size: [u32; 2], color: impl Fn(u32, u32) -> [f32; 3]) -> Self {
        let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Self {
            size,
            pixels: positions.map(|(x, y)| color(x, y)).collect(),
        }
    }

    /// The colour of a pixel.
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    /// The same picture with every channel changed.
    pub fn map(&self, channel: impl Fn(f32) -> f32) -> Self {
        Self {
            size: self.size,
            pixels: self.pixels.iter().map(|p| p.map(&channel)).collect(),
        }
    }

    /// An encoded picture, rounded to 8 bits.
    pub fn to_rgb8(&self) -> RgbImage {
        let byte = |channel: f32| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
        RgbImage::from_fn(self.size[0], self.size[1], |x, y| {
            Rgb(self.at(x, y).map(byte))
        })
    }
}

impl From<&Rgba32FImage> for Frame {
    fn from(image: &Rgba32FImage) -> Self {
        Self {
            size: [image.width, image.height],
            pixels: image.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect(),
        }
    }
}

/// PSNR of rounding to 8 bits, a mean squared error of 1/12: pictures that are equal after it may
/// differ by as much before.
const PSNR_OF_ROUNDING: f64 = 58.922;

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

#[cfg(test)]
mod summary_tests {
    use super::*;
    use crate::record::{PictureError, Times};

    #[test]
    fn filters_are_ours_and_cost_what_bevys_camera_costs_times_a_factor() {
        let picture = |scene: &str, setting: &str, psnr_db| PictureRow {
            scene: scene.into(),
            setting: setting.into(),
            error: PictureError {
                psnr_db,
                ..PictureError::default()
            },
            ..PictureRow::default()
        };
        let time = |setting: &str, gpu_ms| TimeRow {
            scene: NO_OVERDRAW.into(),
            setting: setting.into(),
            times: Times {
                gpu_ms: Some(gpu_ms),
                ..Times::default()
            },
            ..TimeRow::default()
        };
        let [first, second] = [SCENES[0].name, SCENES[1].name];
        let found = YCoCgFb::summary(&Rows {
            pictures: vec![
                picture(first, "default", Some(50.0)),
                picture(second, "default", None),
                picture(first, "quad", Some(40.0)),
                picture(second, "quad", Some(30.0)),
                picture(first, "rg11b10ufloat", Some(45.0)),
                picture(second, "rg11b10ufloat", Some(45.0)),
                picture("a photograph", "quad", Some(1.0)),
            ],
            times: vec![
                time(REFERENCE, 2.0),
                time("packed_hdr", 3.0),
                time("packed_hdr quad", 1.0),
                time("rg11b10ufloat", 1.0),
            ],
        });
        let choice = |name: &str, error, cost, source| Choice {
            name: name.into(),
            error,
            cost,
            source,
        };
        let expected = [
            choice(
                "default",
                (50.0 + PSNR_OF_ROUNDING) / 2.0,
                1.5,
                Source::Ours,
            ),
            choice("quad", 35.0, 0.5, Source::Ours),
            choice("rg11b10ufloat", 45.0, 0.5, Source::Ours),
        ];
        assert_eq!(found.choices, expected);
    }
}

//! `wavelet-tex info`.

use std::fmt::Write;

use bevy_wavelet_tex::{
    codec::{
        haar::Transform,
        image::{ColorSpace, Content, WaveletImage},
        quantizer::PlaneCoding,
    },
    file,
};
use serde::Serialize;

use crate::{
    args::{InfoArgs, name},
    error::Error,
    files,
};

/// Everything but the blocks.
#[derive(Serialize)]
struct Info {
    version: u16,
    content: &'static str,
    color_space: &'static str,
    /// Width and height in pixels.
    size: [u32; 2],
    levels: u32,
    /// Of the largest level.
    bits_per_pixel: f64,
    /// Of all levels.
    gpu_bytes: usize,
    planes: Vec<PlaneInfo>,
}

#[derive(Serialize)]
struct PlaneInfo {
    name: &'static str,
    /// What alpha 0 and 1 stand for, in units of the plane.
    mean_range: [f32; 2],
    /// Largest stored detail, in units of the plane.
    detail_range: f32,
    gamma: f32,
    transform: &'static str,
    /// Weight of HH; only of the partially inverted Haar transform.
    w: Option<f32>,
}

/// Describes a texture.
pub fn run(args: &InfoArgs) -> Result<String, Error> {
    let bytes = files::read(&args.file)?;
    let texture = file::read(&bytes).map_err(|e| Error::file(&args.file, e))?;
    // The reader has checked it and has no further use for it.
    let version = u16::from_le_bytes([bytes[8], bytes[9]]);
    let info = Info::new(&texture, version);
    if args.json {
        return Ok(serde_json::to_string_pretty(&info).expect("plain data"));
    }
    Ok(format!("{}: {}", args.file.display(), info.text()))
}

impl Info {
    fn new(texture: &WaveletImage, version: u16) -> Self {
        let names: &[&str] = match texture.content {
            Content::Gray => &["Y"],
            Content::Color => &["Y", "Co", "Cg"],
            Content::Normal => &["X", "Y"],
        };
        let codings = texture.groups.iter().flat_map(|g| &g.codings);
        Self {
            version,
            content: name(texture.content),
            color_space: match texture.color_space {
                ColorSpace::Srgb => "srgb",
                ColorSpace::Linear => "linear",
            },
            size: texture.size,
            levels: texture.levels,
            bits_per_pixel: texture.bits_per_pixel(),
            gpu_bytes: texture.gpu_bytes(),
            planes: names
                .iter()
                .zip(codings)
                .map(|(name, coding)| PlaneInfo::new(name, coding))
                .collect(),
        }
    }

    fn text(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "wavelet texture, version {}\n{}, {}, {width} x {height} pixels, mip levels: {}\n\
             {:.3} bits per pixel, {} bytes on the GPU\n\
             plane  mean range         detail range  gamma  transform",
            self.version,
            self.content,
            self.color_space,
            self.levels,
            self.bits_per_pixel,
            self.gpu_bytes,
        );
        for p in &self.planes {
            let [min, max] = p.mean_range;
            let w = p.w.map_or(String::new(), |w| format!(", w = {w}"));
            let _ = write!(
                text,
                "\n{:5}  {min:7.4} to {max:7.4}  {:12.4}  {:5.2}  {}{w}",
                p.name, p.detail_range, p.gamma, p.transform,
            );
        }
        text
    }
}

impl PlaneInfo {
    fn new(name: &'static str, coding: &PlaneCoding) -> Self {
        let (transform, w) = match coding.transform {
            Transform::Haar => ("haar", None),
            Transform::PartiallyInvertedHaar { w } => ("partially_inverted_haar", Some(w)),
        };
        Self {
            name,
            mean_range: [coding.mean_min, coding.mean_max],
            detail_range: coding.range,
            gamma: coding.gamma,
            transform,
            w,
        }
    }
}

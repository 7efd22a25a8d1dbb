//! The commands that read textures, `wavelet-tex decode` and `wavelet-tex info`.

use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

use bevy_wavelet_tex::{
    codec::{
        haar::Transform,
        image::{ColorSpace, Content, WaveletImage},
        packing::Packing,
        quantizer::PlaneCoding,
    },
    file,
};
use serde::Serialize;

use crate::{
    Error,
    args::{DecodeArgs, InfoArgs},
    batch::{self, Report},
    files::{self, Destination, Input, Outputs},
    picture::{Picture, is_own_png},
};

/// Decodes one level of each texture to a PNG, and says a line about each.
pub fn decode(args: &DecodeArgs) -> Result<Report, Error> {
    let is_other = |path: &Path| !files::has_extension(path, &[file::EXTENSION]);
    let (named, out) = files::split_output(&args.inputs, args.out.as_deref(), is_other);
    let destination = Destination::new(out, files::is_single(named), "png")?;
    let (inputs, mut errors) = files::expand(named, &[file::EXTENSION]);
    let mut outputs = Outputs::default();
    inputs.iter().for_each(|input| outputs.protect(&input.path));
    let mut tasks: Vec<(&Input, PathBuf)> = Vec::new();
    for input in &inputs {
        let output = destination.of(input, "png");
        match output.and_then(|o| outputs.take(&o, &input.path).map(|()| o)) {
            Ok(output) => tasks.push((input, output)),
            Err(error) => errors.push(error),
        }
    }
    let (lines, result) = batch::run(
        &tasks,
        errors,
        |(input, _)| &input.path,
        |(input, output), batch| {
            let texture = files::read_texture(&input.path)?;
            if args.level >= texture.levels {
                return Err(Error::file(
                    &input.path,
                    format_args!(
                        "there is no level {}: its levels are 0 to {}",
                        args.level,
                        texture.levels - 1
                    ),
                ));
            }
            files::check_output(output, destination.makes_folders(), args.force, is_own_png)?;
            let picture = Picture::from_texture(&texture, args.level);
            picture.write_png(output)?;
            let [width, height] = picture.size;
            batch.say(&format!("{}: {width} x {height} pixels", output.display()));
            Ok(())
        },
    );
    let text = match lines.len() {
        0 | 1 => String::new(),
        files => format!("{files} files decoded"),
    };
    Ok((text, result))
}

/// All parameters of a texture, without its blocks.
#[derive(Serialize)]
struct Info {
    file: String,
    version: u16,
    content: &'static str,
    color_space: &'static str,
    /// Width and height in pixels.
    size: [u32; 2],
    levels: u32,
    /// Bits per pixel of the largest level.
    bits_per_pixel: f64,
    /// Bytes of all levels on the GPU.
    gpu_bytes: usize,
    /// RGB of one unit of luma and of each plane of chroma, where they are not those of YCoCg.
    #[serde(skip_serializing_if = "Option::is_none")]
    axes: Option<[[f32; 3]; 3]>,
    /// The planes of a wavelet texture.
    planes: Vec<PlaneInfo>,
    /// The texture of an image without a wavelet.
    #[serde(skip_serializing_if = "Option::is_none")]
    plain: Option<PlainInfo>,
}

#[derive(Serialize)]
struct PlainInfo {
    format: &'static str,
    /// Width and height in texels.
    size: [u32; 2],
}

#[derive(Serialize)]
struct PlaneInfo {
    name: &'static str,
    packing: &'static str,
    /// Width and height in pixels.
    size: [u32; 2],
    /// Values that 0 and 1 stand for, in units of the plane.
    low_range: [f32; 2],
    /// How the details are stored; `None` for packings without a wavelet.
    #[serde(flatten)]
    details: Option<DetailInfo>,
}

#[derive(Serialize)]
struct DetailInfo {
    /// Largest stored detail, in units of the plane.
    detail_range: f32,
    gamma: f32,
    predictor: f32,
    transform: &'static str,
    /// Weight of HH; `None` for the Haar transform.
    w: Option<f32>,
}

/// Describes textures.
pub fn info(args: &InfoArgs) -> Result<Report, Error> {
    let (inputs, errors) = files::expand(&args.inputs, &[file::EXTENSION]);
    let (infos, result) = batch::run(
        &inputs,
        errors,
        |input| &input.path,
        |input, _| {
            let texture = files::read_texture(&input.path)?;
            Ok(Info::new(input.path.display().to_string(), &texture))
        },
    );
    let text = match infos.as_slice() {
        [] => String::new(),
        [one] if args.json && files::is_single(&args.inputs) => {
            serde_json::to_string_pretty(one).expect("plain data")
        }
        all if args.json => serde_json::to_string_pretty(all).expect("plain data"),
        all => all.iter().map(Info::text).collect::<Vec<_>>().join("\n\n"),
    };
    Ok((text, result))
}

impl Info {
    fn new(file: String, texture: &WaveletImage) -> Self {
        let names: &[&str] = match texture.content {
            Content::Gray => &["Y"],
            Content::Color => &["Y", "Co", "Cg"],
            Content::ColorAlpha => &["Y", "A", "Co", "Cg"],
            Content::Normal => &["X", "Y"],
        };
        let planes = texture.groups().flat_map(|group| {
            let size = group.plane_size(texture.size, 0);
            group
                .codings
                .iter()
                .map(move |coding| (group, size, coding))
        });
        let axes = texture.axes();
        Self {
            file,
            version: file::version(texture),
            content: texture.content.name(),
            color_space: match texture.color_space {
                ColorSpace::Srgb => "srgb",
                ColorSpace::Linear => "linear",
            },
            size: texture.size,
            levels: texture.levels,
            bits_per_pixel: texture.bits_per_pixel(),
            gpu_bytes: texture.gpu_bytes(),
            axes: (!axes.are_ycocg()).then_some(axes.rgb),
            planes: names
                .iter()
                .zip(planes)
                .map(|(name, (group, size, coding))| PlaneInfo {
                    name,
                    packing: group.packing.name(),
                    size,
                    low_range: [coding.low_min, coding.low_max],
                    details: DetailInfo::new(group.packing, coding),
                })
                .collect(),
            plain: texture.plain().map(|plain| PlainInfo {
                format: plain.format.name(),
                size: plain.size,
            }),
        }
    }

    fn text(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "{}: wavelet texture, version {}\n{}, {}, {width} x {height} pixels, mip levels: {}\n\
             {:.3} bits per pixel, {} bytes on the GPU",
            self.file,
            self.version,
            self.content,
            self.color_space,
            self.levels,
            self.bits_per_pixel,
            self.gpu_bytes,
        );
        if let Some(plain) = &self.plain {
            let [w, h] = plain.size;
            let _ = write!(
                text,
                "\nplain {} texture of {w} x {h} texels: at its rate, the least error",
                plain.format,
            );
            return text;
        }
        for (name, [r, g, b]) in ["luma", "Co", "Cg"].iter().zip(self.axes.iter().flatten()) {
            let _ = write!(text, "\n{name} along RGB {r:.3}, {g:.3}, {b:.3}");
        }
        text += "\nplane  packing  size           range              details";
        for p in &self.planes {
            let ([min, max], [width, height]) = (p.low_range, p.size);
            let size = format!("{width} x {height}");
            let _ = write!(
                text,
                "\n{:5}  {:7}  {size:13}  {min:7.4} to {max:7.4}",
                p.name, p.packing,
            );
            if let Some(d) = &p.details {
                let w = d.w.map_or(String::new(), |w| format!(", w {w}"));
                let _ = write!(
                    text,
                    "  {}{w}, range {:.4}, gamma {:.2}, predictor {:.3}",
                    d.transform, d.detail_range, d.gamma, d.predictor,
                );
            }
        }
        text
    }
}

impl DetailInfo {
    fn new(packing: Packing, coding: &PlaneCoding) -> Option<Self> {
        let (transform, w) = match coding.transform {
            Transform::Haar => ("haar", None),
            Transform::PartiallyInvertedHaar { w } => ("partially_inverted_haar", Some(w)),
        };
        packing.is_wavelet().then_some(Self {
            detail_range: coding.range,
            gamma: coding.gamma,
            predictor: coding.predictor,
            transform,
            w,
        })
    }
}

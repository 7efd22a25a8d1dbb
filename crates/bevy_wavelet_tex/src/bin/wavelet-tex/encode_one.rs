//! Encoding of one image.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    time::Instant,
};

use bevy_wavelet_tex::{
    codec::{
        encoder::encode,
        image::{ColorSpace, Content, WaveletImage},
        settings::EncodeSettings,
        source::Source,
    },
    file,
};
use serde::Serialize;

use crate::{
    args::EncodeArgs, batch, choices::Role, compare::Difference, error::Error, files,
    picture::Picture,
};

/// The result of one image.
#[derive(Serialize)]
pub struct Row {
    input: PathBuf,
    output: PathBuf,
    content: &'static str,
    /// The packing of luma, or the format and size of a plain texture.
    packing: String,
    size: [u32; 2],
    levels: u32,
    bpp: f64,
    bytes: usize,
    psnr_db: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    mean_angle_degrees: Option<f64>,
    encode_s: f64,
    #[serde(skip)]
    quality: String,
}

impl Row {
    pub fn text(&self) -> String {
        let [width, height] = self.size;
        format!(
            "{}: {width} x {height} pixels, {}, {:.2} bpp, {} bytes, {}, {:.2} s",
            self.output.display(),
            self.packing,
            self.bpp,
            self.bytes,
            self.quality,
            self.encode_s,
        )
    }
}

/// Encodes one image. In a glTF file, `role` is that of the image.
pub fn encode_one(
    input: &Path,
    mut picture: Picture,
    role: Option<Role>,
    args: &EncodeArgs,
    output: PathBuf,
) -> Result<Row, Error> {
    let mut settings = args.settings(picture.is_gray(), role)?;
    // In a glTF file the role alone decides.
    if role.is_none() && picture.color_space == Some(ColorSpace::Linear) {
        settings.color_space = ColorSpace::Linear;
    }
    if settings.rate.content(false) == Content::Normal {
        picture.complete_normals();
    }
    if let Some(most) = args.max_size
        && picture.size.iter().any(|s| *s > most)
    {
        picture = picture.reduced(most, settings.color_space);
    }
    if !args.alpha && picture.is_transparent() {
        warn(
            input,
            "the image has transparent pixels; alpha is dropped (--alpha keeps it)",
        );
    }
    let start = Instant::now();
    let texture = encoded(input, &picture, &settings)?;
    let encode_s = start.elapsed().as_secs_f64();
    let bytes = match args.zstd {
        Some(level) => file::write_zstd(&texture, level),
        None => file::write(&texture),
    };
    files::write(&output, &bytes)?;
    let decoded = Picture::from_texture(&texture, 0);
    let difference = Difference::between(&picture, &decoded, false);
    if let Some(wanted) = settings.min_psnr_db
        && difference.psnr_db < wanted
    {
        warn(
            input,
            &format!(
                "the largest rate reaches {:.2} dB, not {wanted}",
                difference.psnr_db
            ),
        );
    }
    Ok(Row {
        input: input.to_path_buf(),
        output,
        content: texture.content.name(),
        packing: texture.storage_name(),
        size: texture.size,
        levels: texture.levels,
        bpp: texture.bits_per_pixel(),
        bytes: bytes.len(),
        psnr_db: difference.psnr_db,
        mean_angle_degrees: difference.angles.map(|angles| angles.mean_angle_degrees),
        encode_s,
        quality: difference.quality(),
    })
}

fn encoded(
    path: &Path,
    picture: &Picture,
    settings: &EncodeSettings,
) -> Result<WaveletImage, Error> {
    let bar = batch::bar("mip levels");
    let source = Source::new(picture.size, picture.source());
    let texture = encode(&source, settings, &|_, parts| {
        bar.set_length(parts as u64);
        bar.inc(1);
    });
    bar.finish_and_clear();
    texture.map_err(|e| Error::file(path, e))
}

fn warn(path: &Path, problem: &str) {
    let _ = writeln!(io::stderr(), "warning: {}: {problem}", path.display());
}

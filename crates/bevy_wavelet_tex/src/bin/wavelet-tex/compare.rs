//! The command `wavelet-tex compare`.

use std::fmt::Write;

use bevy_wavelet_tex::codec::{
    angle::{Angles, unit, unit_of},
    color::ycocg_from_rgb,
    image::Content,
};
use serde::Serialize;

use crate::{args::CompareArgs, error::Error, image_file, picture::Picture};

/// The error between two pictures of one size.
#[derive(Serialize)]
pub struct Difference {
    /// Whether luma was compared (Y of YCoCg, as in the thesis), because one of the pictures is
    /// gray.
    luma: bool,
    /// Mean squared error of the channels, in 8-bit units squared; of colour as far as alpha shows it, of normals as unit
    /// vectors.
    pub mse: f64,
    /// PSNR in dB; infinite when the pictures are identical, which JSON writes as null.
    pub psnr_db: f64,
    /// Largest error of a channel, in 8-bit units.
    max_error: f64,
    /// Angles between the normals, for normal maps only.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub angles: Option<Angles>,
}

/// Compares two files.
pub fn run(args: &CompareArgs) -> Result<String, Error> {
    let a = image_file::read_any(&args.a)?;
    let b = image_file::read_any(&args.b)?;
    if a.size != b.size {
        let [width, height] = a.size;
        return Err(Error::file(
            &args.b,
            format_args!(
                "{} x {} pixels, but {} has {width} x {height}: only images of one size can be \
                 compared",
                b.size[0],
                b.size[1],
                args.a.display(),
            ),
        ));
    }
    let difference = Difference::between(&a, &b, args.normal);
    if args.json {
        return Ok(serde_json::to_string_pretty(&difference).expect("plain data"));
    }
    let mut text = format!(
        "mse {:.4}, {}, max error {} of 255",
        difference.mse,
        difference.quality(),
        difference.max_error,
    );
    if difference.luma {
        let gray = if a.is_gray() { &args.a } else { &args.b };
        let _ = write!(text, " (of luma: {} is gray)", gray.display());
    }
    Ok(text)
}

impl Difference {
    /// Compares pictures of one size. The angles are measured when one of them is a normal map, or
    /// when `normal` is set.
    pub fn between(a: &Picture, b: &Picture, normal: bool) -> Self {
        let luma = a.is_gray() != b.is_gray();
        let normal = !luma && (normal || [a, b].iter().any(|p| p.content == Content::Normal));
        let direction = |[r, g, b, alpha]: [f64; 4]| {
            let [x, y, z] = unit([r, g, b].map(|v| v / 127.5 - 1.0));
            let [x, y, z] = [x, y, z].map(|v| (v * 127.5 + 127.5).round());
            [x, y, z, alpha]
        };
        // Without an alpha channel pixels are opaque.
        let channels = if !normal && (a.has_alpha || b.has_alpha) {
            4
        } else {
            3
        };
        let (mut sum, mut max_error) = (0.0, 0.0_f64);
        let mut add = |error: f64| {
            sum += error * error;
            max_error = max_error.max(error.abs());
        };
        for (a, b) in (0..a.pixels.len()).map(|i| (a.at(i), b.at(i))) {
            if luma {
                add(luma_of(a) - luma_of(b));
                continue;
            }
            let [a, b] = [a, b].map(|pixel| if normal { direction(pixel) } else { pixel });
            // A colour counts as far as it is seen.
            let seen = a[3].max(b[3]) / 255.0;
            (0..3).for_each(|i| add(seen * (a[i] - b[i])));
            if channels == 4 {
                add(a[3] - b[3]);
            }
        }
        let values = if luma { 1 } else { channels } * a.pixels.len();
        let mse = sum / values as f64;
        let angles = normal.then(|| {
            let pairs = a.pixels.iter().zip(&b.pixels);
            Angles::between(pairs.map(|(a, b)| (unit_of(*a), unit_of(*b))))
        });
        Self {
            luma,
            mse,
            psnr_db: 10.0 * (255.0 * 255.0 / mse).log10(),
            max_error,
            angles,
        }
    }

    /// Formats the PSNR and, for normals, the mean angle.
    pub fn quality(&self) -> String {
        let psnr = if self.psnr_db.is_finite() {
            format!("{:.2} dB", self.psnr_db)
        } else {
            "identical".into()
        };
        self.angles.as_ref().map_or(psnr.clone(), |angles| {
            let mean = angles.mean_angle_degrees;
            format!("{psnr}, {mean:.2} degrees on average")
        })
    }
}

/// Y of YCoCg, in 8-bit units.
fn luma_of(pixel: [f64; 4]) -> f64 {
    let [r, g, b, _] = pixel.map(|v| v as f32);
    ycocg_from_rgb([r, g, b]).y.into()
}

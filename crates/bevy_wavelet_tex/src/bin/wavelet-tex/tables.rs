//! The command `wavelet-tex tables`, which reproduces the thesis's Tables 3.1 and 3.3 with this
//! code, and compares the rates with baselines of the same bits. The thesis measured Lena in these
//! two tables; here they are means over the given images.

mod correlation;
mod lossless;
mod markdown;
mod published;
mod spaces;
mod wavelets;

use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb, encoder::Method, haar::Transform, image::Content, quality::psnr_of,
    rate::Rate, search::Effort,
};
use serde::Serialize;

use crate::{
    Report,
    args::TablesArgs,
    batch,
    bench::{self, Row},
    error::Error,
    inputs,
    picture::Picture,
    study,
};
use spaces::Space;
use wavelets::Wavelet;

/// The rows of Table 3.3, each with the candidates for its parameter.
const WAVELETS: [(&str, &[Wavelet]); 4] = [
    ("Haar", &[Wavelet::Real(Transform::Haar)]),
    ("PLHaar", &[Wavelet::PlHaar]),
    ("S-transform", &[Wavelet::S]),
    ("PI-Haar", &PARTLY_INVERTED),
];

const PARTLY_INVERTED: [Wavelet; 5] = [
    partly_inverted(0.2),
    partly_inverted(0.4),
    partly_inverted(0.6),
    partly_inverted(0.8),
    partly_inverted(1.0),
];

const fn partly_inverted(w: f32) -> Wavelet {
    Wavelet::Real(Transform::PartiallyInvertedHaar { w })
}

/// All tables, as means over the images.
#[derive(Serialize)]
pub struct Tables {
    /// Number of images.
    images: usize,
    table_3_1: Vec<Figure>,
    table_3_3_wavelets: Vec<Figure>,
    table_3_3_color_spaces: Vec<Figure>,
    /// The rates and their baselines, as in `bench --study`.
    rates: Vec<RateFigure>,
    others: Vec<Other>,
}

/// A measured figure and that of the thesis.
#[derive(Serialize)]
struct Figure {
    what: String,
    /// Measured value: the mean squared error in Table 3.1, otherwise the PSNR in dB.
    here: f64,
    thesis: f64,
}

#[derive(Serialize)]
struct RateFigure {
    rate: String,
    bpp: f64,
    psnr_db: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    thesis_psnr_db: Option<f64>,
}

#[derive(Serialize)]
struct Other {
    what: &'static str,
    bpp: f64,
    psnr_db: f64,
    source: &'static str,
}

/// The measurements of one image.
struct Measured {
    correlation: Vec<f64>,
    wavelets: Vec<f64>,
    spaces: Vec<f64>,
    rows: Vec<Row>,
}

/// Measures every image and averages.
pub fn run(args: &TablesArgs) -> Result<Report, Error> {
    let inputs = inputs::expand(&args.inputs, &["png"])?;
    let pictures = |r: &Rate| r.content(false) != Content::Normal;
    let rates: Vec<Rate> = Rate::ALL.into_iter().filter(pictures).collect();
    let (measured, result) = batch::run(&inputs, |input, _| {
        let picture = Picture::read_png(&input.path)?;
        if picture.size.iter().any(|&side| side < 16) {
            let problem =
                "smaller than 16 x 16 pixels, the smallest size that `tables` can measure";
            return Err(Error::file(&input.path, problem));
        }
        let mut rows = bench::rows("", &picture, &rates, Effort::Default, Method::Best)
            .map_err(|e| Error::file(&input.path, e))?;
        rows.extend(study::rows("", &picture));
        let cropped = Cropped::new(&picture);
        Ok(Measured {
            correlation: cropped.correlation(),
            wavelets: WAVELETS
                .map(|(_, family)| cropped.psnr(Space::YCoCgR, family))
                .to_vec(),
            spaces: Space::ALL
                .map(|space| cropped.psnr(space, &PARTLY_INVERTED))
                .to_vec(),
            rows,
        })
    });
    if measured.is_empty() {
        return Ok((String::new(), result));
    }
    let tables = Tables::new(&measured);
    let text = if args.json {
        serde_json::to_string_pretty(&tables).expect("plain data")
    } else {
        markdown::text(&tables)
    };
    Ok((text, result))
}

impl Tables {
    fn new(measured: &[Measured]) -> Self {
        let mean = |value: &dyn Fn(&Measured) -> f64| {
            let values: Vec<f64> = measured
                .iter()
                .map(value)
                .filter(|v| v.is_finite())
                .collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        let figures = |names: Vec<String>, thesis: &[f64], of: fn(&Measured) -> &[f64]| {
            let rows = names.into_iter().zip(thesis).enumerate();
            rows.map(|(i, (what, thesis))| Figure {
                what,
                here: mean(&|m| of(m)[i]),
                thesis: *thesis,
            })
            .collect()
        };
        let cases = correlation::CASES.map(|(transform, together)| match (transform, together) {
            (Transform::Haar, false) => "Haar: HL, 0, 0".to_string(),
            (Transform::Haar, true) => "Haar: HL, LH, HH".into(),
            (_, false) => "PI-Haar: HL', 0, 0".into(),
            (_, true) => "PI-Haar: HL', LH', HH'".into(),
        });
        let rates = measured[0]
            .rows
            .iter()
            .enumerate()
            .map(|(i, row)| RateFigure {
                rate: row.rate.clone(),
                bpp: mean(&|m| m.rows[i].bpp),
                psnr_db: mean(&|m| m.rows[i].psnr_db),
                thesis_psnr_db: published::thesis(&row.rate),
            });
        let others = published::OTHERS.map(|(what, bpp, psnr_db, source)| Other {
            what,
            bpp,
            psnr_db,
            source,
        });
        Self {
            images: measured.len(),
            table_3_1: figures(cases.to_vec(), &published::CORRELATION, |m| &m.correlation),
            table_3_3_wavelets: figures(
                WAVELETS.map(|(name, _)| name.to_string()).to_vec(),
                &published::WAVELETS,
                |m| &m.wavelets,
            ),
            table_3_3_color_spaces: figures(
                Space::ALL.map(|space| space.name().to_string()).to_vec(),
                &published::SPACES,
                |m| &m.spaces,
            ),
            rates: rates.collect(),
            others: others.into(),
        }
    }
}

/// A picture that is cropped to multiples of 16, so that planes of half its size have whole blocks.
struct Cropped {
    size: [usize; 2],
    pixels: Vec<[u8; 3]>,
}

impl Cropped {
    fn new(picture: &Picture) -> Self {
        let full_width = picture.size[0] as usize;
        let size = picture.size.map(|side| side as usize / 16 * 16);
        let rows = picture.pixels.chunks(full_width).take(size[1]);
        let pixels = rows.flat_map(|row| &row[..size[0]]);
        Self {
            size,
            pixels: pixels.map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        }
    }

    /// Measures Table 3.1 for luma.
    fn correlation(&self) -> Vec<f64> {
        let [width, height] = self.size;
        let luma: Vec<f32> = self
            .pixels
            .iter()
            .map(|p| ycocg_from_rgb(p.map(f32::from)).y.round())
            .collect();
        let at = |x: usize, y: usize| luma[y * width + x];
        let size = [width / 2, height / 2];
        let quads: Vec<[f32; 4]> = (0..size[0] * size[1])
            .map(|i| {
                let (x, y) = (2 * (i % size[0]), 2 * (i / size[0]));
                [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)]
            })
            .collect();
        let size = size.map(|s| s as u32);
        correlation::CASES
            .map(|(transform, together)| {
                correlation::error_of_first(transform, together, &quads, size)
            })
            .to_vec()
    }

    /// PSNR of the picture at 3 bits per pixel, as in the thesis: luma at full size, chromas at
    /// half the size, each as a wavelet plane of 8 bits in BC3.
    fn psnr(&self, space: Space, family: &[Wavelet]) -> f64 {
        let [width, height] = self.size;
        let planes: [Vec<i32>; 3] =
            std::array::from_fn(|c| self.pixels.iter().map(|p| space.forward(*p)[c]).collect());
        let luma = wavelets::through(family, &planes[0], self.size);
        let small = [width / 2, height / 2];
        let [first, second] = [1, 2].map(|c| {
            let mean = |i: usize| {
                let first = i / small[0] * 2 * width + i % small[0] * 2;
                let quad = [0, 1, width, width + 1].map(|offset| planes[c][first + offset]);
                (quad.iter().sum::<i32>() as f32 / 4.0).round() as i32
            };
            let means: Vec<i32> = (0..small[0] * small[1]).map(mean).collect();
            signed_through(family, &means, small)
        });
        let error: f64 = (0..width * height)
            .map(|i| {
                let half = i / width / 2 * small[0] + i % width / 2;
                let rgb = space.inverse([luma[i], first[half], second[half]]);
                let pairs = rgb.iter().zip(self.pixels[i]);
                let errors = pairs.map(|(a, b)| a.round().clamp(0.0, 255.0) - f32::from(b));
                errors.map(|e| f64::from(e * e)).sum::<f64>()
            })
            .sum();
        psnr_of(error / (3 * width * height) as f64)
    }
}

/// Encodes and decodes a plane of signed values in blocks of 8 bits, in 256 steps of 1 where that
/// covers the range, otherwise in steps of 2 (thesis section 3.6.1).
fn signed_through(family: &[Wavelet], plane: &[i32], size: [usize; 2]) -> Vec<f32> {
    let least = plane.iter().copied().min().unwrap_or(0);
    let most = plane.iter().copied().max().unwrap_or(0);
    let step = if most - least <= 255 { 1 } else { 2 };
    let codes: Vec<i32> = plane.iter().map(|v| (v - least) / step).collect();
    let back = wavelets::through(family, &codes, size);
    back.iter()
        .map(|v| v * step as f32 + least as f32)
        .collect()
}

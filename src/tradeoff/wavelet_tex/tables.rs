//! Tables of what the summary leaves out: the thesis's tables, every rate beside baselines of the
//! same bits, and normal maps.

use std::{collections::BTreeMap, fmt::Write};

use bevy_wavelet_tex::codec::blocks::BlockFormat;

use super::{
    baselines::{FILTERS, scaled_name},
    encoded::{FROM_COLOR, ORIGINAL},
    normals::EXACT,
    published,
};
use crate::{
    record::{Measurement, Report},
    tradeoff::summary::means,
};

/// The rates, and the format of a lower resolution with the same bits.
const RATES: [(&str, BlockFormat, f64); 6] = [
    ("gray2", BlockFormat::Bc4, 2.0),
    ("gray3", BlockFormat::Bc4, 3.0),
    ("color2.25", BlockFormat::Bc1, 2.25),
    ("color3", BlockFormat::Bc1, 3.0),
    ("color3.25", BlockFormat::Bc1, 3.25),
    ("color5", BlockFormat::Bc7, 5.0),
];

/// All tables as means over the photographs; nothing where the baselines were not measured.
pub fn tables(report: &Report) -> String {
    let rows = &report.measurements;
    let photographs = Photographs::new(rows);
    let mut text = String::new();
    if rows.iter().any(|row| row.reference == published::TABLE_3_1) {
        text += &thesis(&photographs);
        text += &rates(&photographs);
    }
    if rows.iter().any(|row| row.reference == EXACT) {
        text += &normals(rows);
    }
    text
}

/// The rows of the Kodak images, or of the photograph that is generated where there are none.
struct Photographs<'a>(Vec<&'a Measurement>);

impl<'a> Photographs<'a> {
    fn new(rows: &'a [Measurement]) -> Self {
        let is_kodak = |row: &&Measurement| row.scene.starts_with("kodim");
        let prefix = if rows.iter().any(|row| is_kodak(&row)) {
            "kodim"
        } else {
            "photo"
        };
        let rows = rows.iter().filter(|row| row.scene.starts_with(prefix));
        Self(rows.collect())
    }

    fn means(
        &self,
        reference: &str,
        figure: impl Fn(&Measurement) -> Option<f64>,
    ) -> BTreeMap<String, f64> {
        let rows = self.0.iter().copied();
        means(rows.filter(|row| row.reference == reference), figure)
    }

    /// Number of pixels of an image, from the row of the image itself.
    fn pixels(&self, scene: &str) -> Option<f64> {
        let mut rows = self.0.iter().filter(|row| row.scene == scene);
        let row = rows.find(|row| row.reference == "itself")?;
        let bytes_per_pixel = if row.setting == "r8" { 1.0 } else { 4.0 };
        Some(row.bytes? as f64 / bytes_per_pixel)
    }
}

fn thesis(photographs: &Photographs) -> String {
    let errors = photographs.means(published::TABLE_3_1, |row| row.mse);
    let psnrs = photographs.means(published::TABLE_3_3, |row| row.psnr_db);
    let mut text = String::new();
    for (title, column, figures, published) in [
        (
            "Table 3.1: details stored together",
            "MSE of R",
            &errors,
            &published::CORRELATION[..],
        ),
        (
            "Table 3.3: wavelets",
            "PSNR, dB",
            &psnrs,
            &published::WAVELETS,
        ),
        (
            "Table 3.3: colour spaces",
            "PSNR, dB",
            &psnrs,
            &published::SPACES,
        ),
    ] {
        let _ = write!(
            text,
            "\n{title}\n\n| | {column} | thesis, of Lena |\n| --- | --- | --- |\n"
        );
        for (name, thesis) in published {
            // YCoCg-R is measured with PI-Haar, as that row of the wavelets.
            let row = if *name == "YCoCg-R" { "PI-Haar" } else { name };
            let here = figures.get(row).copied().unwrap_or(f64::NAN);
            let _ = writeln!(text, "| {name} | {here:.2} | {thesis:.2} |");
        }
    }
    text
}

fn rates(photographs: &Photographs) -> String {
    let psnrs = photographs.means(ORIGINAL, |row| row.psnr_db);
    let bits = photographs.means(ORIGINAL, |row| {
        Some(8.0 * row.bytes? as f64 / photographs.pixels(&row.scene)?)
    });
    let figure = |figures: &BTreeMap<String, f64>, setting: &str| {
        let figure = figures.get(setting);
        figure.map_or(String::new(), |figure| format!("{figure:.2}"))
    };
    let mut text = "\nRates: PSNR, dB\n\n\
        | rate | bpp | here | thesis | same bits, lower resolution | bilinear | bicubic |\n\
        | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_string();
    let two_levels = (
        "two levels",
        "two levels".to_string(),
        BlockFormat::Bc4,
        1.5,
    );
    let setting = |rate: &str| match rate.starts_with("gray") {
        true => format!("{rate}{FROM_COLOR}"),
        false => format!("{rate} default"),
    };
    let rates = RATES.map(|(rate, format, bpp)| (rate, setting(rate), format, bpp));
    for (rate, setting, format, bpp) in rates.into_iter().chain([two_levels]) {
        let thesis = published::RATES.iter().find(|(name, ..)| *name == rate);
        let thesis = thesis.map_or(String::new(), |(.., psnr)| format!("{psnr:.1}"));
        let [bilinear, bicubic] =
            FILTERS.map(|(name, _)| figure(&psnrs, &scaled_name(format, bpp, name)));
        let _ = writeln!(
            text,
            "| {rate} | {} | {} | {thesis} | {} | {bilinear} | {bicubic} |",
            figure(&bits, &setting),
            figure(&psnrs, &setting),
            format.name(),
        );
    }
    text += "\nOther formats: PSNR, dB\n\n\
        | format | bpp | PSNR | source |\n| --- | --- | --- | --- |\n";
    for (format, name) in [
        (BlockFormat::Bc4, "BC4, gray"),
        (BlockFormat::Bc1, "BC1"),
        (BlockFormat::Bc7, "BC7"),
    ] {
        let [bits, psnr] = [&bits, &psnrs].map(|figures| figure(figures, format.name()));
        let _ = writeln!(text, "| {name} | {bits} | {psnr} | here |");
    }
    for (name, bpp, psnr, source) in published::OTHERS {
        let _ = writeln!(text, "| {name} | {bpp:.2} | {psnr:.2} | {source} |");
    }
    text
}

fn normals(rows: &[Measurement]) -> String {
    let columns = ["mean", "99 of 100", "largest"];
    let mut text = format!(
        "\nNormal maps: angles to the original, in degrees\n\n| map | format | {} |\n\
         | --- | --- | --- | --- | --- |\n",
        columns.join(" | ")
    );
    for row in rows.iter().filter(|row| row.reference == EXACT) {
        let angle = |name: &str| format!("{:.3}", row.angle_degrees[name]);
        let angles = columns.map(angle).join(" | ");
        let _ = writeln!(text, "| {} | {} | {angles} |", row.scene, row.setting);
    }
    text
}

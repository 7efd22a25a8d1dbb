//! Formatting of the tables as Markdown.

use std::fmt::Write;

use super::{Figure, Tables};

/// The row of `bench --study` with the same bits as a rate, and the format of that row.
fn rivals(rate: &str) -> Option<(&'static str, &'static str)> {
    Some(match rate {
        "gray1.5" => ("bc4-gray-1.5", "BC4"),
        "gray2" => ("bc4-gray-2", "BC4"),
        "gray3" => ("bc4-gray-3", "BC4"),
        "color2.25" => ("bc1-2.25", "BC1"),
        "color3" => ("bc1-3", "BC1"),
        "color3.25" => ("bc1-3.25", "BC1"),
        "color5" => ("bc7-5", "BC7"),
        _ => return None,
    })
}

/// Formats all tables.
pub fn text(tables: &Tables) -> String {
    let mut text = format!("Means over {} images.\n", tables.images);
    for (title, column, figures) in [
        (
            "Table 3.1: details stored together",
            "MSE of R",
            &tables.table_3_1,
        ),
        (
            "Table 3.3: wavelets",
            "PSNR, dB",
            &tables.table_3_3_wavelets,
        ),
        (
            "Table 3.3: colour spaces",
            "PSNR, dB",
            &tables.table_3_3_color_spaces,
        ),
    ] {
        let _ = write!(text, "\n{}", figures_table(title, column, figures));
    }
    let psnr = |rate: &str| {
        let found = tables.rates.iter().find(|figure| figure.rate == rate);
        found.map_or(String::new(), |figure| format!("{:.2}", figure.psnr_db))
    };
    text += "\nRates: PSNR, dB\n\n\
        | rate | bpp | here | thesis | same bits, lower resolution | bilinear | bicubic |\n\
        | --- | --- | --- | --- | --- | --- | --- |\n";
    for figure in &tables.rates {
        let Some((rival, format)) = rivals(&figure.rate) else {
            continue;
        };
        let thesis = figure
            .thesis_psnr_db
            .map_or(String::new(), |v| format!("{v:.1}"));
        let [bilinear, bicubic] = ["bilinear", "bicubic"].map(|f| psnr(&format!("{rival}-{f}")));
        let _ = writeln!(
            text,
            "| {} | {:.2} | {:.2} | {thesis} | {format} | {bilinear} | {bicubic} |",
            figure.rate, figure.bpp, figure.psnr_db,
        );
    }
    text += "\nOther formats: PSNR, dB\n\n\
        | format | bpp | PSNR | source |\n| --- | --- | --- | --- |\n";
    for (rate, name) in [("bc4-gray", "BC4, gray"), ("bc1", "BC1"), ("bc7", "BC7")] {
        let found = tables.rates.iter().find(|figure| figure.rate == rate);
        let bpp = found.map_or(0.0, |figure| figure.bpp);
        let _ = writeln!(text, "| {name} | {bpp:.2} | {} | here |", psnr(rate));
    }
    for other in &tables.others {
        let _ = writeln!(
            text,
            "| {} | {:.2} | {:.2} | {} |",
            other.what, other.bpp, other.psnr_db, other.source,
        );
    }
    text.truncate(text.trim_end().len());
    text
}

fn figures_table(title: &str, column: &str, figures: &[Figure]) -> String {
    let mut text = format!("{title}\n\n| | {column} | thesis, of Lena |\n| --- | --- | --- |\n");
    for figure in figures {
        let _ = writeln!(
            text,
            "| {} | {:.2} | {:.2} |",
            figure.what, figure.here, figure.thesis
        );
    }
    text
}

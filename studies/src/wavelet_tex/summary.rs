//! The rates as quality against bits per pixel.

use std::collections::HashMap;

use super::{encoded::ORIGINAL, published::RATES};
use crate::{
    record::Report,
    summary::{Choice, Need, Quantity, Source, Summary, means},
};

/// How many images the Kodak set has. Other figures are comparable with means of all of them only.
const KODAK: usize = 24;
/// The setting of the images themselves, which take four bytes a pixel.
const UNCOMPRESSED: &str = "rgba8";

/// The rates on photographs in colour with the default effort: the Kodak images, or the generated
/// one.
pub fn summary(report: &Report) -> Summary {
    let pixels: HashMap<_, _> = report
        .measurements
        .iter()
        .filter(|row| row.setting == UNCOMPRESSED && row.psnr_db.is_none())
        .filter_map(|row| Some((row.scene.as_str(), row.bytes? as f64 / 4.0)))
        .collect();
    let is_kodak = |scene: &str| scene.starts_with("kodim");
    let kodak = pixels.keys().filter(|scene| is_kodak(scene)).count();
    let rows: Vec<_> = report
        .measurements
        .iter()
        .filter(|row| pixels.contains_key(row.scene.as_str()))
        .filter(|row| is_kodak(&row.scene) || kodak == 0 && row.scene == "photo")
        .collect();
    let compared = rows.iter().copied().filter(|row| row.reference == ORIGINAL);
    let quality = means(compared, |row| row.psnr_db);
    let bits = means(rows.iter().copied(), |row| {
        Some(8.0 * row.bytes? as f64 / pixels.get(row.scene.as_str())?)
    });
    let measured = quality.iter().filter_map(|(name, psnr)| {
        let (rate, source) = match name.split_once(' ') {
            Some((rate, "default")) => (rate, Source::Ours),
            Some((_, "fast" | "best")) => return None,
            // Formats at full size only: those of a lower resolution are in the tables.
            Some(_) => return None,
            None => (name.as_str(), Source::Baseline),
        };
        Some(Choice {
            name: rate.into(),
            error: *psnr,
            cost: *bits.get(name)?,
            source,
        })
    });
    let in_color = RATES.iter().filter(|(rate, ..)| rate.starts_with("color"));
    let published = in_color.map(|(_, bits, psnr)| Choice {
        name: format!("thesis {bits}"),
        error: *psnr,
        cost: *bits,
        source: Source::Published,
    });
    Summary {
        title: "bevy_wavelet_tex: quality of photographs against memory".into(),
        error: Quantity::more("mean PSNR", "dB", 1),
        cost: Quantity::less("memory", "bits per pixel", 2),
        choices: measured
            .chain(published.filter(|_| kodak == KODAK))
            .collect(),
        needs: vec![
            Need::LeastCost,
            Need::Cost(3.0),
            Need::Error(38.0),
            Need::LeastError,
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Measurement;

    #[test]
    fn rates_are_ours_and_other_formats_baselines() {
        let row = |scene: &str, setting: &str, psnr_db, bytes| Measurement {
            scene: scene.into(),
            setting: setting.into(),
            reference: ORIGINAL.into(),
            psnr_db,
            bytes: Some(bytes),
            ..Measurement::default()
        };
        let mut measurements = vec![
            row("photo", "rgba8", None, 400),
            row("photo", "color3 default", Some(20.0), 38),
        ];
        for i in 1..=KODAK {
            let kodim = format!("kodim{i:02}");
            measurements.extend([
                row(&kodim, "rgba8", None, 400),
                row(&kodim, "color3 fast", Some(33.0), 38),
                row(&kodim, "color3 default", Some(34.0), 38),
                row(&kodim, "bc1", Some(36.0), 50),
            ]);
        }
        let found = |rows: &[Measurement]| {
            summary(&Report {
                measurements: rows.to_vec(),
                ..Report::default()
            })
        };
        let all = found(&measurements);
        let choice = |name: &str| all.choices.iter().find(|c| c.name == name);
        let ours = choice("color3").expect("ours");
        assert_eq!((ours.error, ours.source), (34.0, Source::Ours));
        assert!((ours.cost - 3.04).abs() < 1e-9);
        assert_eq!(choice("bc1").map(|c| c.source), Some(Source::Baseline));
        assert_eq!(all.choices.len(), 2 + 3);
        // Of some of the images, nothing was published.
        let some = found(&measurements[..6]);
        assert_eq!(some.choices.len(), 2);
        assert_eq!(found(&measurements[..2]).choices[0].error, 20.0);
    }
}

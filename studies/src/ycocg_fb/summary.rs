//! The filters as quality against the time of a frame.

use super::{cost::NO_OVERDRAW, settings::REFERENCE};
use crate::{
    record::Report,
    summary::{Choice, Need, Quantity, Source, Summary, means},
};
use bevy_frugal_lab::scenes::ycocg_fb::scenes::SCENES;

/// PSNR of rounding to 8 bits, a mean squared error of 1/12: pictures that are equal after it may
/// differ by as much before.
const PSNR_OF_ROUNDING: f64 = 58.922;

/// Mean PSNR over the rendered scenes, none above that of rounding to 8 bits, and the time of a frame
/// with nothing in it, which is the worst case: nothing is saved, and the resolve is paid.
pub fn summary(report: &Report) -> Summary {
    let rows = &report.measurements;
    let is_scene = |name: &str| SCENES.iter().any(|scene| scene.name == name);
    let quality = means(rows.iter().filter(|row| is_scene(&row.scene)), |row| {
        let equal = (row.mse == Some(0.0)).then_some(f64::INFINITY);
        Some(row.psnr_db.or(equal)?.min(PSNR_OF_ROUNDING))
    });
    let times = means(rows.iter().filter(|row| row.scene == NO_OVERDRAW), |row| {
        row.gpu_ms.or(row.cpu_ms)
    });
    let bevy = times.get(REFERENCE).copied();
    let choices = times.iter().filter_map(|(name, time)| {
        let (setting, source) = match name.as_str() {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Measurement;

    #[test]
    fn filters_are_ours_and_cost_what_bevys_camera_costs_times_a_factor() {
        let row = |scene: &str, setting: &str, psnr_db: Option<f64>, gpu_ms| Measurement {
            scene: scene.into(),
            setting: setting.into(),
            mse: psnr_db.map(|psnr| 65025.0 / 10f64.powf(psnr / 10.0)),
            psnr_db: psnr_db.filter(|psnr| psnr.is_finite()),
            gpu_ms,
            ..Measurement::default()
        };
        let scene = SCENES[0].name;
        let measurements = vec![
            row(scene, "default", Some(50.0), None),
            row(SCENES[1].name, "default", Some(f64::INFINITY), None),
            row(scene, "quad", Some(40.0), None),
            row(SCENES[1].name, "quad", Some(30.0), None),
            row(scene, "rg11b10ufloat", Some(45.0), None),
            row(SCENES[1].name, "rg11b10ufloat", Some(45.0), None),
            row("a photograph", "quad", Some(1.0), None),
            row(NO_OVERDRAW, REFERENCE, None, Some(2.0)),
            row(NO_OVERDRAW, "packed_hdr", None, Some(3.0)),
            row(NO_OVERDRAW, "packed_hdr quad", None, Some(1.0)),
            row(NO_OVERDRAW, "rg11b10ufloat", None, Some(1.0)),
        ];
        let found = summary(&Report {
            measurements,
            ..Report::default()
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

//! The methods as error against time.

use crate::{
    record::Report,
    summary::{Choice, Need, Quantity, Source, Summary, means},
};
use bevy_frugal_lab::lookups::scenes::SCENES;

/// The thesis's methods on a GTX 460 (Table 5.1): mean squared error against its reference, and
/// speed as a share of that of the texture unit's own filter.
const THESIS: [(&str, f64, f64); 6] = [
    ("reference", 0.0, 0.055),
    ("linear", 0.007, 0.074),
    ("bilinear", 6.4, 0.088),
    ("approximate", 30.0, 0.387),
    ("spatial", 55.0, 0.455),
    ("texture unit", 126.0, 1.0),
];
/// What times are compared with: the texture unit's own filter, or a model of it in the shader where the
/// driver has none.
const UNITS: [(&str, &str); 2] = [
    ("hardware_af16", "of 16x anisotropy"),
    ("software_af16", "of 16x anisotropy in a shader"),
];

/// Mean squared error against exact EWA over all scenes, and time in the first.
pub fn summary(report: &Report) -> Summary {
    let rows = &report.measurements;
    let is_scene = |name: &str| SCENES.iter().any(|scene| scene.name == name);
    let errors = rows
        .iter()
        .filter(|row| row.reference == "ewa" && is_scene(&row.scene));
    let errors = means(errors, |row| row.mse);
    let times = means(rows.iter().filter(|row| row.reference == "time"), |row| {
        row.gpu_ms.or(row.cpu_ms)
    });
    let unit = UNITS.iter().find(|(name, _)| times.contains_key(*name));
    let (unit, unit_name) = *unit.unwrap_or(&UNITS[0]);
    let unit = times.get(unit);
    let measured = errors.iter().filter_map(|(name, error)| {
        let is_bevys = name == "trilinear" || name == "hardware_af16";
        Some(Choice {
            name: name.clone(),
            error: *error,
            cost: times.get(name)? / unit?,
            source: if is_bevys {
                Source::Baseline
            } else {
                Source::Ours
            },
        })
    });
    let published = THESIS.map(|(name, error, speed)| Choice {
        name: format!("thesis: {name}"),
        error,
        cost: 1.0 / speed,
        source: Source::Published,
    });
    Summary {
        title: "bevy_ewa: error against time".into(),
        error: Quantity::less("mean squared error against exact EWA", "", 2).logarithmic_from(1e-3),
        cost: Quantity::less("time", unit_name, 2).logarithmic_from(1e-3),
        choices: measured.chain(published).collect(),
        needs: vec![
            Need::LeastError,
            Need::Error(1.0),
            Need::Error(30.0),
            Need::LeastCost,
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Measurement;

    #[test]
    fn times_are_those_of_the_texture_unit_or_of_its_model() {
        let row = |setting: &str, reference: &str, mse, gpu_ms| Measurement {
            scene: SCENES[0].name.into(),
            setting: setting.into(),
            reference: reference.into(),
            mse,
            gpu_ms,
            ..Measurement::default()
        };
        let mut measurements = vec![
            row("linear", "ewa", Some(0.5), None),
            row("linear", "truth", Some(9.0), None),
            row("linear", "time", None, Some(6.0)),
            row("software_af16", "time", None, Some(3.0)),
        ];
        let cost = |measurements: &[Measurement]| {
            let found = summary(&Report {
                measurements: measurements.to_vec(),
                ..Report::default()
            });
            let linear = found.choices.iter().find(|c| c.name == "linear");
            linear.map(|c| (c.error, c.cost))
        };
        assert_eq!(cost(&measurements), Some((0.5, 2.0)));
        measurements.push(row("hardware_af16", "time", None, Some(1.0)));
        assert_eq!(cost(&measurements), Some((0.5, 6.0)));
    }
}

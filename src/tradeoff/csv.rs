//! A report as comma-separated values (RFC 4180, but for line feeds alone), one line a measurement.

use std::{collections::BTreeMap, fmt::Write};

use crate::record::Report;

/// The table with a line of names; figures that were not measured are empty.
pub fn csv(report: &Report) -> String {
    let mut text = String::from(
        "plugin,scene,setting,reference,mse,psnr_db,flip,max_error,gpu_ms,cpu_ms,bytes,fetches,\
         fetched_bytes,relative_error,bias,relative_time,stage_ms\n",
    );
    for m in &report.measurements {
        for name in [&m.plugin, &m.scene, &m.setting, &m.reference] {
            let _ = write!(text, "{},", field(name));
        }
        let figures = [m.mse, m.psnr_db, m.flip, m.max_error, m.gpu_ms, m.cpu_ms];
        for figure in figures {
            let _ = write!(text, "{},", number(figure));
        }
        let bytes = m.bytes.map_or(String::new(), |bytes| bytes.to_string());
        let _ = write!(text, "{bytes},");
        for figure in [m.fetches, m.fetched_bytes, m.relative_error, m.bias] {
            let _ = write!(text, "{},", number(figure));
        }
        let _ = writeln!(text, "{},{}", pairs(&m.relative_time), pairs(&m.stage_ms));
    }
    text
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// `name=value` with spaces between.
fn pairs(figures: &BTreeMap<String, f64>) -> String {
    let pairs: Vec<_> = figures
        .iter()
        .map(|(name, value)| format!("{name}={value}"))
        .collect();
    field(&pairs.join(" "))
}

/// Quoted where it must be.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\r', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Measurement;

    #[test]
    fn every_line_has_every_column() {
        let row = Measurement {
            scene: "tall, \"wide\"".into(),
            mse: Some(0.5),
            bytes: Some(7),
            relative_time: [("bc7".to_string(), 0.5)].into(),
            stage_ms: [("gather".to_string(), 1.5), ("list".into(), 2.0)].into(),
            ..Measurement::default()
        };
        let text = csv(&Report {
            measurements: vec![row],
            ..Report::default()
        });
        let lines: Vec<_> = text.split('\n').collect();
        let columns = lines[0].split(',').count();
        assert_eq!(
            lines[1],
            ",\"tall, \"\"wide\"\"\",,,0.5,,,,,,7,,,,,bc7=0.5,gather=1.5 list=2"
        );
        // One more by the comma between quotes.
        assert_eq!(lines[1].split(',').count(), columns + 1);
        assert_eq!(lines.len(), 3);
    }
}

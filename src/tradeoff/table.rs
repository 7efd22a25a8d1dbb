//! A report as a table of text.

use std::fmt::Write;

use crate::record::Report;

/// One line a measurement, figures that were not measured as `-`.
pub(super) fn table(report: &Report) -> String {
    let mut text = String::new();
    let adapter = &report.adapter;
    if !adapter.name.is_empty() {
        let _ = writeln!(text, "{} ({})", adapter.name, adapter.driver);
    }
    let _ = writeln!(
        text,
        "{:<21} {:<20} {:>8} {:>8} {:>7} {:>4} {:>8} {:>9} {:>9} {:>5} {:>7} {:>7}  stages ms, others",
        "scene",
        "setting",
        "mse",
        "psnr dB",
        "flip",
        "max",
        "gpu ms",
        "cpu ms",
        "bytes",
        "fetch",
        "error %",
        "bias %"
    );
    for m in &report.measurements {
        let bytes = m.bytes.map_or("-".into(), |bytes| bytes.to_string());
        let stages = m.stage_ms.iter();
        let stages = stages.map(|(name, ms)| format!("{name} {ms:.2}"));
        let times = m.relative_time.iter();
        let times = times.map(|(name, time)| format!("{time:.1} x {name}"));
        let fetched = m.fetched_bytes.map(|b| format!("fetches {b:.1} bytes"));
        let rest: Vec<_> = stages.chain(times).chain(fetched).collect();
        let line = format!(
            "{:<21} {:<20} {:>8} {:>8} {:>7} {:>4} {:>8} {:>9} {:>9} {:>5} {:>7} {:>7}  {}",
            m.scene,
            m.setting,
            figure(m.mse, 2),
            figure(m.psnr_db, 2),
            figure(m.flip, 4),
            figure(m.max_error, 0),
            figure(m.gpu_ms, 3),
            figure(m.cpu_ms, 2),
            bytes,
            figure(m.fetches, 0),
            figure(m.relative_error.map(|error| 100.0 * error), 1),
            figure(m.bias.map(|bias| 100.0 * bias), 1),
            rest.join(", "),
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

fn figure(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.decimals$}"))
}

//! The page of pictures.

use std::fmt::Write;

use crate::runner::{Outcome, pictures::picture_name};

const STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1100px; margin: 2em auto; padding: 0 1em;
  background: #16181c; color: #ddd }
.split { position: relative; overflow: hidden; --position: 50% }
.split img, .difference { display: block; width: 100% }
.split .before { position: absolute; inset: 0;
  clip-path: inset(0 calc(100% - var(--position)) 0 0) }
.split .line { position: absolute; top: 0; bottom: 0; left: var(--position); width: 1px;
  background: #fff; pointer-events: none }
.split input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0;
  cursor: ew-resize }
.pair { display: grid; grid-template-columns: 1fr 1fr 1fr; gap: 1em; margin-top: 1em }
figure { margin: 0 } figure img { width: 100% } table { border-spacing: 1em 0 }
td { font-variant-numeric: tabular-nums }
";

/// The page for scenes with their descriptions; it refers to the pictures beside it.
pub(super) fn html(outcomes: &[(&str, Outcome)]) -> String {
    let mut sections = String::new();
    for (description, outcome) in outcomes {
        sections.push_str(&section(description, outcome));
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <title>bevy_frugal gallery</title>\n<style>{STYLE}</style>\n\
         <h1>bevy_frugal gallery</h1>\n{sections}</html>\n"
    )
}

fn section(description: &str, outcome: &Outcome) -> String {
    let name = outcome.scene;
    let [before, after, difference] =
        ["before", "after", "difference"].map(|part| picture_name(name, part));
    format!(
        "<section>\n<h2>{name}</h2>\n<p>{}. Plugin: {}.</p>\n\
         <div class=\"split\"><img src=\"{after}\" alt=\"after\">\
         <img class=\"before\" src=\"{before}\" alt=\"before\"><div class=\"line\"></div>\
         <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.1\" \
         aria-label=\"before or after\" \
         oninput=\"this.parentNode.style.setProperty('--position', this.value + '%')\"></div>\n\
         <div class=\"pair\">{}{}{}</div>\n{}</section>\n",
        escape(description),
        outcome.plugin,
        figure(&before, "before"),
        figure(&after, "after"),
        figure(&difference, "difference (FLIP)"),
        figures(outcome),
    )
}

fn figure(path: &str, caption: &str) -> String {
    format!(
        "<figure><a href=\"{path}\"><img src=\"{path}\" alt=\"{caption}\"></a>\
         <figcaption>{caption}</figcaption></figure>"
    )
}

fn figures(outcome: &Outcome) -> String {
    let mut rows = vec![
        ("adapter".to_string(), escape(&outcome.adapter.name)),
        (
            "size".into(),
            format!("{} x {}", outcome.width, outcome.height),
        ),
        (
            "PSNR".into(),
            match outcome.psnr_db {
                Some(psnr) => format!("{psnr:.2} dB"),
                None => "infinite (equal)".into(),
            },
        ),
        ("FLIP".into(), format!("{:.4}", outcome.flip)),
        (
            "largest difference".into(),
            format!("{} of 255", outcome.max_error),
        ),
    ];
    for (side, times) in [("before", outcome.before), ("after", outcome.after)] {
        for (unit, time) in [("CPU", times.cpu_ms), ("GPU", times.gpu_ms)] {
            if let Some(ms) = time {
                rows.push((format!("{unit} time {side}"), format!("{ms:.2} ms")));
            }
        }
    }
    for (name, bytes) in &outcome.memory {
        let kib = *bytes as f64 / 1024.0;
        rows.push((format!("memory {}", escape(name)), format!("{kib:.1} KiB")));
    }
    for (name, text) in &outcome.notes {
        rows.push((escape(name), escape(text)));
    }
    for (name, value) in &outcome.settings {
        rows.push(((*name).into(), escape(&value.to_string())));
    }
    let mut table = String::from("<table>\n");
    for (name, value) in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "<tr><th align=\"left\">{name}</th><td>{value}</td></tr>"
        );
    }
    table + "</table>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

//! Error against time, one point a setting and scene, both axes in powers.

use std::fmt::Write;

use crate::record::{Measurement, Report};

const SIZE: [f64; 2] = [900.0, 560.0];
/// Left, right, top, bottom.
const MARGIN: [f64; 4] = [70.0, 250.0, 30.0, 60.0];
/// A colour a scene, in the order in which scenes come.
const COLORS: [&str; 4] = ["#1b6fb5", "#c4551b", "#2f8f4e", "#7a4fb0"];

struct Point<'a> {
    row: &'a Measurement,
    milliseconds: f64,
    percent: f64,
}

/// A plot as SVG; discs are marched, squares are propagated.
pub fn error_against_time(report: &Report) -> String {
    let points: Vec<Point> = report.measurements.iter().filter_map(point).collect();
    let x = Axis::new(
        points.iter().map(|p| p.milliseconds),
        MARGIN[0],
        SIZE[0] - MARGIN[1],
    );
    let y = Axis::new(
        points.iter().map(|p| p.percent),
        SIZE[1] - MARGIN[3],
        MARGIN[2],
    );
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" \
         viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        SIZE[0], SIZE[1]
    );
    for (value, at) in x.ticks() {
        let _ = writeln!(
            svg,
            "<path d=\"M{at:.1} {} V{}\" stroke=\"#ddd\"/>\
             <text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{value}</text>",
            MARGIN[2],
            SIZE[1] - MARGIN[3],
            SIZE[1] - MARGIN[3] + 18.0
        );
    }
    for (value, at) in y.ticks() {
        let _ = writeln!(
            svg,
            "<path d=\"M{} {at:.1} H{}\" stroke=\"#ddd\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{value}</text>",
            MARGIN[0],
            SIZE[0] - MARGIN[1],
            MARGIN[0] - 8.0,
            at + 4.0
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\">volume's time on the GPU, ms a frame ({})</text>\n\
         <text x=\"10\" y=\"18\">relative error, %</text>",
        MARGIN[0],
        SIZE[1] - 15.0,
        escaped(&report.adapter.name)
    );
    let mut scenes: Vec<&str> = Vec::new();
    for point in &points {
        let scene = point.row.scene.as_str();
        let index = scenes.iter().position(|s| *s == scene).unwrap_or_else(|| {
            scenes.push(scene);
            scenes.len() - 1
        });
        let (at_x, at_y) = (x.at(point.milliseconds), y.at(point.percent));
        let color = COLORS[index % COLORS.len()];
        let title = format!(
            "{scene}, {}: {:.1}%, {:.2} ms",
            point.row.setting, point.percent, point.milliseconds
        );
        let shape = if point.row.setting.starts_with("propagate") {
            format!(
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"8\" height=\"8\"",
                at_x - 4.0,
                at_y - 4.0
            )
        } else {
            format!("<circle cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" r=\"4.5\"")
        };
        let _ = writeln!(
            svg,
            "{shape} fill=\"{color}\"><title>{}</title></{}>\
             <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"8\" fill=\"#555\">{}</text>",
            escaped(&title),
            if shape.starts_with("<rect") {
                "rect"
            } else {
                "circle"
            },
            at_x + 6.0,
            at_y - 3.0,
            escaped(&point.row.setting)
        );
    }
    for (index, scene) in scenes.iter().enumerate() {
        let at = MARGIN[2] + 20.0 * (index + 1) as f64;
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{at}\" fill=\"{}\">{}</text>",
            SIZE[0] - MARGIN[1] + 90.0,
            COLORS[index % COLORS.len()],
            escaped(scene)
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\">disc: march, square: propagate</text>\n</svg>",
        SIZE[0] - MARGIN[1] + 50.0,
        MARGIN[2] + 20.0 * (scenes.len() + 1) as f64
    );
    svg
}

fn point(row: &Measurement) -> Option<Point<'_>> {
    let milliseconds: f64 = row.stage_ms.values().sum();
    let percent = 100.0 * row.relative_error?;
    (milliseconds > 0.0 && percent > 0.0).then_some(Point {
        row,
        milliseconds,
        percent,
    })
}

/// From values to positions, by their logarithms.
struct Axis {
    low: f64,
    high: f64,
    start: f64,
    end: f64,
}

impl Axis {
    /// From `start` to `end`, with room at both ends of the values.
    fn new(values: impl Iterator<Item = f64>, start: f64, end: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let (low, high) = if low <= high {
            (low, high)
        } else {
            (1.0, 10.0)
        };
        Self {
            low: 0.7 * low,
            high: 1.4 * high,
            start,
            end,
        }
    }

    fn at(&self, value: f64) -> f64 {
        let part = (value / self.low).ln() / (self.high / self.low).ln();
        self.start + part * (self.end - self.start)
    }

    /// 1, 2 and 5 of each power of ten.
    fn ticks(&self) -> Vec<(f64, f64)> {
        (-3..7)
            .flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)))
            .filter(|value| (self.low..=self.high).contains(value))
            .map(|value| ((value * 1e6).round() / 1e6, self.at(value)))
            .collect()
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(setting: &str, error: Option<f64>, milliseconds: f64) -> Measurement {
        Measurement {
            scene: "a & b".into(),
            setting: setting.into(),
            relative_error: error,
            stage_ms: [("gather".to_string(), milliseconds)].into(),
            ..Measurement::default()
        }
    }

    #[test]
    fn a_point_for_each_row_with_error_and_time() {
        let measurements = vec![
            row("march", Some(0.1), 3.0),
            row("propagate", Some(0.2), 30.0),
            row("ambient_occlusion", None, 1.0),
            row("march 0 ms", Some(0.2), 0.0),
        ];
        let report = Report {
            measurements,
            ..Report::default()
        };
        let svg = error_against_time(&report);
        assert_eq!(svg.matches("<circle").count(), 1);
        assert_eq!(svg.matches("</rect>").count(), 1);
        assert!(svg.contains("a &amp; b") && !svg.contains("NaN"), "{svg}");
        // Slower is further to the right, worse further up.
        let x = Axis::new([3.0, 30.0].into_iter(), 0.0, 100.0);
        assert!(x.at(3.0) < x.at(30.0) && x.at(3.0) > 0.0 && x.at(30.0) < 100.0);
    }

    #[test]
    fn nothing_measured_is_an_empty_plot() {
        let svg = error_against_time(&Report::default());
        assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"));
    }
}

//! The memory figures as a table.

use std::collections::BTreeMap;

use bevy_egui::egui;

use crate::runner::MemoryFigures;

/// Draws a row a name, with the figures of before and after beside each other.
pub(super) fn draw(ui: &mut egui::Ui, figures: &MemoryFigures) {
    if figures.0.is_empty() {
        return;
    }
    egui::Grid::new("lab_memory")
        .num_columns(3)
        .striped(true)
        .show(ui, |ui| {
            for heading in ["memory", "before", "after"] {
                ui.strong(heading);
            }
            ui.end_row();
            for (name, sides) in rows(figures) {
                ui.label(name);
                for bytes in sides {
                    ui.monospace(bytes.map(text).unwrap_or_default());
                }
                ui.end_row();
            }
        });
}

/// Names with the bytes before and after; a name without a side stands in the first column.
fn rows(figures: &MemoryFigures) -> BTreeMap<&str, [Option<u64>; 2]> {
    let mut rows = BTreeMap::<&str, [Option<u64>; 2]>::new();
    for (name, &bytes) in &figures.0 {
        let (name, column) = match name.strip_suffix(" after") {
            Some(name) => (name, 1),
            None => (name.strip_suffix(" before").unwrap_or(name), 0),
        };
        rows.entry(name).or_default()[column] = Some(bytes);
    }
    rows
}

/// In KiB below one MiB, else in MiB.
fn text(bytes: u64) -> String {
    let kib = bytes as f64 / 1024.0;
    if kib < 1024.0 {
        format!("{kib:.1} KiB")
    } else {
        format!("{:.2} MiB", kib / 1024.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_a_name_share_a_row() {
        let figure = |(name, bytes): (&str, u64)| (name.to_string(), bytes);
        let figures = [("a after", 2), ("a before", 1), ("b after", 3), ("c", 4)];
        let figures = MemoryFigures(figures.map(figure).into());
        let rows: Vec<_> = rows(&figures).into_iter().collect();
        let expected = [
            ("a", [Some(1), Some(2)]),
            ("b", [None, Some(3)]),
            ("c", [Some(4), None]),
        ];
        assert_eq!(rows, expected);
    }

    #[test]
    fn large_figures_are_in_mebibytes() {
        assert_eq!(text(1536), "1.5 KiB");
        assert_eq!(text(3 << 19), "1.50 MiB");
    }
}

//! Summaries in Markdown: the report, and the tables of advice in other documents.

use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

use bevy_frugal_lab::ROOT;

use crate::{
    record::{FileError, Report},
    summary::{Source, Summary},
};

/// A table in Markdown.
pub fn table<H: AsRef<str>>(heads: &[H], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let heads: Vec<_> = heads.iter().map(AsRef::as_ref).collect();
    let mut text = format!(
        "| {} |\n|{}\n",
        heads.join(" | "),
        " --- |".repeat(heads.len())
    );
    for cells in rows {
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

/// A number, or nothing where there is none.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or(String::new(), |value| format!("{value:.decimals$}"))
}

/// What to choose for which need.
pub fn advice(summary: &Summary) -> String {
    let heads = [
        "if you need",
        "choose",
        summary.error.name,
        summary.cost.name,
    ];
    let rows = summary.needs.iter().map(|&need| {
        let cells = match summary.choice_for(need) {
            Some(choice) => [
                format!("`{}`", choice.name),
                summary.error.text(choice.error),
                summary.cost.text(choice.cost),
            ],
            None => [
                "nothing measured meets it".into(),
                String::new(),
                String::new(),
            ],
        };
        [vec![summary.need_text(need)], cells.into()].concat()
    });
    table(&heads, rows)
}

/// A chapter of the report: the chart, the advice, and every choice.
pub fn chapter(name: &str, summary: &Summary, machine: &str) -> String {
    let Summary {
        title, error, cost, ..
    } = summary;
    let front = summary.pareto_front();
    let mut choices: Vec<_> = summary.choices.iter().collect();
    choices.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let rows = choices.into_iter().map(|choice| {
        let source = match choice.source {
            Source::Ours => "",
            Source::Baseline => "baseline",
            Source::Published => "published",
        };
        vec![
            match front.contains(&choice) {
                true => format!("**{}**", choice.name),
                false => choice.name.clone(),
            },
            number(Some(choice.error), error.decimals),
            number(Some(choice.cost), cost.decimals),
            source.into(),
        ]
    });
    let all = table(&["choice", &error.label(), &cost.label(), ""], rows);
    format!(
        "## {title}\n\nMeasured on {machine}.\n\n![{title}]({name}.svg)\n\n{}\n\
         All that was measured, and what others published; those that nothing of the plugin beats \
         are bold. Every figure is in `{name}.json`.\n\n{all}",
        advice(summary)
    )
}

/// Where and when a report was made.
pub fn machine<Rows>(report: &Report<Rows>) -> String {
    let mut text = match report.adapter.name.as_str() {
        "" => "this machine's processor".to_string(),
        name => name.to_string(),
    };
    if !report.adapter.driver.is_empty() {
        let _ = write!(text, ", {}", report.adapter.driver);
    }
    if !report.date.is_empty() {
        let _ = write!(text, ", {}", report.date);
    }
    text
}

/// The document with what stands between the marks of `name` renewed; none where it has none.
///
/// The marks are `<!-- tradeoff NAME -->` and the next `<!-- end -->`.
pub fn renewed(document: &str, name: &str, text: &str) -> Option<String> {
    let mark = format!("<!-- tradeoff {name} -->\n");
    let (before, rest) = document.split_once(&mark)?;
    let end = rest.find("<!-- end -->")?;
    Some(format!("{before}{mark}{text}{}", &rest[end..]))
}

/// The page with a plugin's figures, by the plugin's name without `bevy_`.
pub fn plugin_page(plugin: &str) -> PathBuf {
    Path::new(ROOT).join(format!("docs/{plugin}.md"))
}

/// Does the same as [`renewed`] in a file, which stays as it is where it has no such marks.
pub fn renew_file(path: &Path, name: &str, text: &str) -> Result<(), FileError> {
    let document = std::fs::read_to_string(path).map_err(|error| FileError::new(path, error))?;
    match renewed(&document, name, text) {
        Some(text) => std::fs::write(path, text).map_err(|error| FileError::new(path, error)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::{Better, tests::summary};

    #[test]
    fn advice_has_a_line_for_each_need() {
        let summary = summary(&[("exact", 1.0, 3.0, Source::Ours)], Better::Less);
        let text = advice(&summary);
        let lines: Vec<_> = text.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| the most accurate | `exact` | 1.0 | 3.0 |",
                "| at most 2.5 of cost | nothing measured meets it |  |  |",
                "| at most 100.0 of error | `exact` | 1.0 | 3.0 |",
            ]
        );
    }

    #[test]
    fn only_what_is_between_the_marks_is_renewed() {
        let document = "a\n<!-- tradeoff ewa -->\nold\n<!-- end -->\nb\n";
        let expected = "a\n<!-- tradeoff ewa -->\nnew\n<!-- end -->\nb\n";
        assert_eq!(renewed(document, "ewa", "new\n").as_deref(), Some(expected));
        assert_eq!(renewed(expected, "ewa", "new\n").as_deref(), Some(expected));
        assert_eq!(renewed(document, "other", "new\n"), None);
    }
}

//! Summaries in Markdown: the report, and the tables of advice in other documents.

use bevy_frugal_lab::ROOT;
use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

use super::{
    study::TradeoffError,
    summary::{Source, Summary},
};
use crate::record::Report;

/// What to choose for which need.
pub fn advice(summary: &Summary) -> String {
    let mut text = format!(
        "| if you need | choose | {} | {} |\n| --- | --- | --- | --- |\n",
        summary.error.name, summary.cost.name
    );
    for &need in &summary.needs {
        let need_text = summary.need_text(need);
        let _ = match summary.choice_for(need) {
            Some(choice) => writeln!(
                text,
                "| {need_text} | `{}` | {} | {} |",
                choice.name,
                summary.error.text(choice.error),
                summary.cost.text(choice.cost)
            ),
            None => writeln!(text, "| {need_text} | nothing measured meets it | | |"),
        };
    }
    text
}

/// A chapter of the report: the chart, the advice, and every choice.
pub fn chapter(name: &str, summary: &Summary, report: &Report) -> String {
    let mut text = format!("## {}\n\n", summary.title);
    let _ = writeln!(text, "Measured on {}.\n", machine(report));
    let _ = writeln!(text, "![{}]({name}.svg)\n", summary.title);
    text += &advice(summary);
    let _ = writeln!(
        text,
        "\nAll that was measured, and what others published; those that nothing of the plugin beats \
         are bold. Every figure is in `{name}.json`.\n\n| choice | {} | {} | |\n\
         | --- | --- | --- | --- |",
        summary.error.label(),
        summary.cost.label()
    );
    let front = summary.pareto_front();
    let mut choices: Vec<_> = summary.choices.iter().collect();
    choices.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    for choice in choices {
        let name = if front.contains(&choice) {
            format!("**{}**", choice.name)
        } else {
            choice.name.clone()
        };
        let source = match choice.source {
            Source::Ours => "",
            Source::Baseline => "baseline",
            Source::Published => "published",
        };
        let _ = writeln!(
            text,
            "| {name} | {:.*} | {:.*} | {source} |",
            summary.error.decimals, choice.error, summary.cost.decimals, choice.cost
        );
    }
    text
}

/// Where and when a report was made.
pub fn machine(report: &Report) -> String {
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

/// The page of a plugin, by the plugin's name without `bevy_`.
pub fn plugin_page(plugin: &str) -> PathBuf {
    Path::new(ROOT).join(format!("crates/bevy_{plugin}/README.md"))
}

/// Does the same as [`renewed`] in a file, which stays as it is where it has no such marks.
///
/// # Errors
/// [`TradeoffError::File`] where the file cannot be read or written.
pub fn renew_file(path: &Path, name: &str, text: &str) -> Result<(), TradeoffError> {
    let document = std::fs::read_to_string(path).map_err(TradeoffError::file(path))?;
    match renewed(&document, name, text) {
        Some(text) => std::fs::write(path, text).map_err(TradeoffError::file(path)),
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
                "| at most 2.5 of cost | nothing measured meets it | | |",
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

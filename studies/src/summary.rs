//! What a user chooses between: each setting of a plugin as one error and one cost, over all scenes
//! of its study. Charts (error against cost, the front of the best choices as a line), tables and advice are made of it.

use std::{collections::BTreeMap, ops::Range};

use plotters::{
    coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter},
    element::DynElement,
    prelude::*,
};

/// The settings of a plugin, by error and cost.
#[derive(Clone, Debug)]
pub struct Summary {
    /// What it is about, in a few words.
    pub title: String,
    pub error: Quantity,
    pub cost: Quantity,
    /// The settings, and what they are compared with.
    pub choices: Vec<Choice>,
    /// What users ask for, in the order of the table.
    pub needs: Vec<Need>,
}

/// An axis of the chart, a column of the table.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    pub name: &'static str,
    /// Its unit, empty for a mere number.
    pub unit: &'static str,
    /// Digits after the point.
    pub decimals: usize,
    /// Which values users want.
    pub better: Better,
    /// Drawn logarithmically, with values below this at it; linearly without.
    pub logarithmic_from: Option<f64>,
}

/// Which of two values users want.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    Less,
    More,
}

impl Quantity {
    /// A quantity of which users want little.
    pub fn less(name: &'static str, unit: &'static str, decimals: usize) -> Self {
        Self {
            name,
            unit,
            decimals,
            better: Better::Less,
            logarithmic_from: None,
        }
    }

    /// A quantity of which users want much.
    pub fn more(name: &'static str, unit: &'static str, decimals: usize) -> Self {
        Self {
            better: Better::More,
            ..Self::less(name, unit, decimals)
        }
    }

    /// The same on a logarithmic axis.
    pub fn logarithmic_from(self, least: f64) -> Self {
        Self {
            logarithmic_from: Some(least),
            ..self
        }
    }

    /// Whether `a` is at least as good as `b`.
    pub fn as_good(&self, a: f64, b: f64) -> bool {
        match self.better {
            Better::Less => a <= b,
            Better::More => a >= b,
        }
    }

    /// A value with its unit.
    pub fn text(&self, value: f64) -> String {
        let number = format!("{value:.*}", self.decimals);
        if self.unit.is_empty() {
            number
        } else {
            format!("{number} {}", self.unit)
        }
    }

    /// Its name with its unit.
    pub fn label(&self) -> String {
        if self.unit.is_empty() {
            self.name.into()
        } else {
            format!("{}, {}", self.name, self.unit)
        }
    }
}

/// A setting, or something that it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Its name in the records.
    pub name: String,
    /// In the unit of [`Summary::error`].
    pub error: f64,
    /// In the unit of [`Summary::cost`].
    pub cost: f64,
    pub source: Source,
}

/// Where a choice comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The plugin's, measured.
    Ours,
    /// Another technique or format, measured in the same run.
    Baseline,
    /// What the thesis or another publication says, on other hardware.
    Published,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Need {
    /// The best there is, whatever it costs.
    LeastError,
    LeastCost,
    /// The cheapest that is at least so good.
    Error(f64),
    /// The best that costs no more.
    Cost(f64),
}

impl Summary {
    /// The plugin's choices that no other one of its choices equals or beats in both.
    pub fn pareto_front(&self) -> Vec<&Choice> {
        let mut front: Vec<&Choice> = self
            .ours()
            .filter(|choice| !self.ours().any(|other| self.beats(other, choice)))
            .collect();
        front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        front.dedup_by(|a, b| a.error == b.error && a.cost == b.cost);
        front
    }

    /// The plugin's choice for a need, if any meets it.
    pub fn choice_for(&self, need: Need) -> Option<&Choice> {
        let front = self.pareto_front();
        let best = |a: &&&Choice, b: &&&Choice| match self.error.better {
            Better::Less => a.error.total_cmp(&b.error),
            Better::More => b.error.total_cmp(&a.error),
        };
        let mut front = front.iter();
        match need {
            Need::LeastCost => front.next(),
            Need::LeastError => front.min_by(best),
            Need::Error(bound) => front.find(|c| self.error.as_good(c.error, bound)),
            Need::Cost(bound) => front.filter(|c| c.cost <= bound).min_by(best),
        }
        .copied()
    }

    /// A need in words.
    pub fn need_text(&self, need: Need) -> String {
        match need {
            Need::LeastError => "the most accurate".into(),
            Need::LeastCost => "the cheapest".into(),
            Need::Error(bound) => {
                let word = match self.error.better {
                    Better::Less => "at most",
                    Better::More => "at least",
                };
                format!("{word} {} of {}", self.error.text(bound), self.error.name)
            }
            Need::Cost(bound) => format!("at most {} of {}", self.cost.text(bound), self.cost.name),
        }
    }

    fn ours(&self) -> impl Iterator<Item = &Choice> {
        self.choices.iter().filter(|c| c.source == Source::Ours)
    }

    fn beats(&self, a: &Choice, b: &Choice) -> bool {
        let as_good = self.error.as_good(a.error, b.error) && a.cost <= b.cost;
        as_good && (a.error != b.error || a.cost != b.cost)
    }
}

/// Means of the figures of each setting, which come with its name. Settings that lack some of the scenes that
/// others have are left out: their means would be of something else.
pub fn means<'a>(
    figures: impl IntoIterator<Item = (&'a String, Option<f64>)>,
) -> BTreeMap<&'a str, f64> {
    let mut by_setting: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (setting, figure) in figures {
        by_setting.entry(setting).or_default().extend(figure);
    }
    let most = by_setting.values().map(Vec::len).max().unwrap_or(0).max(1);
    by_setting
        .into_iter()
        .filter(|(_, values)| values.len() == most)
        .map(|(name, values)| (name, values.iter().sum::<f64>() / most as f64))
        .collect()
}

const SIZE: (u32, u32) = (960, 600);
/// Height of a label's letters in pixels.
const LETTERS: i32 = 12;

const OURS: RGBColor = RGBColor(27, 111, 181);
const BASELINE: RGBColor = RGBColor(196, 85, 27);
const PUBLISHED: RGBColor = RGBColor(110, 110, 110);

type Failure = DrawingAreaErrorKind<std::io::Error>;

/// An SVG of 960 x 600 pixels; `machine` says where the figures were measured.
///
/// Discs are the plugin's settings, and the line joins those that none beats; triangles are baselines that
/// were measured, too; crosses are figures that others published.
pub fn svg(summary: &Summary, machine: &str) -> String {
    let mut svg = String::new();
    // Nothing is written but text in memory: a failure is a defect of the chart, and in its place.
    if let Err(error) = draw(summary, machine, &mut svg) {
        return format!("<svg xmlns=\"http://www.w3.org/2000/svg\"><!-- {error} --></svg>\n");
    }
    svg
}

fn draw(summary: &Summary, machine: &str, svg: &mut String) -> Result<(), Failure> {
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let x = Axis::new(summary.cost, summary.choices.iter().map(|c| c.cost));
    let y = Axis::new(summary.error, summary.choices.iter().map(|c| c.error));
    let mut chart = ChartBuilder::on(&area)
        .caption(&summary.title, ("sans-serif", 18))
        .margin(14)
        .x_label_area_size(50)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(225, 225, 225))
        .label_style(("sans-serif", LETTERS))
        .x_desc(format!("{} ({machine})", summary.cost.label()))
        .y_desc(summary.error.label())
        .draw()?;

    let front = summary.pareto_front();
    let line = front.iter().map(|c| (c.cost, c.error));
    chart
        .draw_series(LineSeries::new(line, OURS.mix(0.5).stroke_width(2)))?
        .label("the best choices")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], OURS.mix(0.5).stroke_width(2)));
    for (source, name) in [
        (Source::Ours, "the plugin"),
        (Source::Baseline, "baselines, measured too"),
        (Source::Published, "published, on other hardware"),
    ] {
        let choices: Vec<_> = { summary.choices.iter() }
            .filter(|choice| choice.source == source)
            .collect();
        if choices.is_empty() {
            continue;
        }
        let style = ("sans-serif", LETTERS).into_font().color(&color(source));
        let named = choices.into_iter().map(|choice| {
            // The table has the names of the others, for which there would be no room.
            let is_named = source != Source::Ours || front.contains(&choice);
            let name = choice.name.clone();
            let name = if is_named { name } else { String::new() };
            EmptyElement::at((choice.cost, choice.error))
                + mark((0, 0), source)
                + Text::new(name, (8, -LETTERS / 2), style.clone())
        });
        chart
            .draw_series(named)?
            .label(name)
            .legend(move |(x, y)| mark((x + 8, y), source));
    }
    chart
        .configure_series_labels()
        .position(match summary.error.better {
            Better::Less => SeriesLabelPosition::UpperRight,
            Better::More => SeriesLabelPosition::LowerRight,
        })
        .label_font(("sans-serif", LETTERS))
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .draw()?;
    area.present()
}

fn color(source: Source) -> RGBColor {
    match source {
        Source::Ours => OURS,
        Source::Baseline => BASELINE,
        Source::Published => PUBLISHED,
    }
}

/// A disc, a triangle or a cross at a place in pixels.
fn mark<'b>(at: (i32, i32), source: Source) -> DynElement<'static, SVGBackend<'b>, (i32, i32)> {
    let filled = color(source).filled();
    match source {
        Source::Ours => Circle::new(at, 5, filled).into_dyn(),
        Source::Baseline => TriangleMarker::new(at, 6, filled).into_dyn(),
        Source::Published => Cross::new(at, 5, color(source).stroke_width(2)).into_dyn(),
    }
}

/// An axis that is linear in its value or in its logarithm.
#[derive(Clone)]
struct Axis {
    quantity: Quantity,
    /// In what is drawn: values, or their logarithms to the base of ten.
    drawn: Range<f64>,
}

impl Axis {
    fn new(quantity: Quantity, values: impl Iterator<Item = f64>) -> Self {
        let ends = values.map(|value| position(&quantity, value));
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let room = (high - low).max(0.1);
        Self {
            quantity,
            drawn: low - 0.08 * room..high + 0.12 * room,
        }
    }

    fn value(&self, at: f64) -> f64 {
        match self.quantity.logarithmic_from {
            Some(_) => 10f64.powf(at),
            None => at,
        }
    }
}

fn position(quantity: &Quantity, value: f64) -> f64 {
    match quantity.logarithmic_from {
        Some(least) => value.max(least).log10(),
        None => value,
    }
}

impl ValueFormatter<f64> for Axis {
    /// With as few digits as a round number needs.
    fn format(value: &f64) -> String {
        let text = format!("{value:.6}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let length = self.drawn.end - self.drawn.start;
        let part = (position(&self.quantity, *value) - self.drawn.start) / length;
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    /// Round values; on a logarithmic axis more digits of each power of ten the fewer powers it has.
    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let Range { start, end } = self.drawn;
        if self.quantity.logarithmic_from.is_none() {
            let linear: plotters::coord::types::RangedCoordf64 = (start..end).into();
            return linear.key_points(hint);
        }
        let digits: &[f64] = match end - start {
            3.0.. => &[1.0],
            1.0.. => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        };
        (start.floor() as i32..=end.ceil() as i32)
            .flat_map(|power| digits.iter().map(move |digit| digit * 10f64.powi(power)))
            .filter(|value| (start..=end).contains(&value.log10()))
            .collect()
    }

    fn range(&self) -> Range<f64> {
        self.value(self.drawn.start)..self.value(self.drawn.end)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn summary(choices: &[(&str, f64, f64, Source)], better: Better) -> Summary {
        let quantity = |name, better| Quantity {
            name,
            unit: "",
            decimals: 1,
            better,
            logarithmic_from: None,
        };
        Summary {
            title: "a & b".into(),
            error: quantity("error", better),
            cost: quantity("cost", Better::Less),
            choices: choices
                .iter()
                .map(|&(name, error, cost, source)| Choice {
                    name: name.into(),
                    error,
                    cost,
                    source,
                })
                .collect(),
            needs: vec![Need::LeastError, Need::Cost(2.5), Need::Error(100.0)],
        }
    }

    const CHOICES: [(&str, f64, f64, Source); 5] = [
        ("exact", 0.0, 10.0, Source::Ours),
        ("good", 1.0, 3.0, Source::Ours),
        ("worse and dearer", 2.0, 4.0, Source::Ours),
        ("fast", 5.0, 1.0, Source::Ours),
        ("baseline", 0.0, 0.5, Source::Baseline),
    ];

    #[test]
    fn the_front_is_what_nothing_of_ours_beats() {
        let summary = summary(&CHOICES, Better::Less);
        let names: Vec<_> = summary.pareto_front().iter().map(|c| &c.name).collect();
        assert_eq!(names, ["fast", "good", "exact"]);
    }

    #[test]
    fn needs_are_met_by_the_front_or_not_at_all() {
        let summary = summary(&CHOICES, Better::Less);
        let name = |need| summary.choice_for(need).map(|c| c.name.as_str());
        assert_eq!(name(Need::LeastError), Some("exact"));
        assert_eq!(name(Need::LeastCost), Some("fast"));
        assert_eq!(name(Need::Error(1.5)), Some("good"));
        assert_eq!(name(Need::Cost(2.5)), Some("fast"));
        assert_eq!(name(Need::Cost(0.9)), None);
        assert_eq!(name(Need::Error(-1.0)), None);
    }

    #[test]
    fn more_can_be_better() {
        let choices = CHOICES.map(|(name, error, cost, source)| (name, 50.0 - error, cost, source));
        let summary = summary(&choices, Better::More);
        assert_eq!(summary.pareto_front().len(), 3);
        let name = |need| summary.choice_for(need).map(|c| c.name.as_str());
        assert_eq!(name(Need::LeastError), Some("exact"));
        assert_eq!(name(Need::Error(48.0)), Some("good"));
    }

    #[test]
    fn means_are_of_settings_with_all_scenes() {
        let [a, b] = ["a", "b"].map(String::from);
        let found = means([
            (&a, Some(1.0)),
            (&a, Some(3.0)),
            (&b, Some(1.0)),
            (&b, None),
        ]);
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [("a", 2.0)]);
    }

    #[test]
    fn every_source_has_its_mark_and_the_front_its_line() {
        let choices = [
            ("exact", 0.0, 10.0, Source::Ours),
            ("fast", 5.0, 1.0, Source::Ours),
            ("baseline <1>", 3.0, 5.0, Source::Baseline),
            ("thesis", 4.0, 2.0, Source::Published),
        ];
        let mut summary = summary(&choices, Better::Less);
        for logarithmic_from in [None, Some(0.01)] {
            summary.error.logarithmic_from = logarithmic_from;
            let svg = svg(&summary, "a machine");
            assert!(svg.ends_with("</svg>\n"), "{svg}");
            // Two marks and one in the legend.
            assert_eq!(svg.matches("<circle").count(), 3, "{svg}");
            for text in [
                "exact",
                "fast",
                "baseline &lt;1&gt;",
                "thesis",
                "a machine",
                "a &amp; b",
            ] {
                assert!(svg.contains(text), "{text}: {svg}");
            }
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }

    #[test]
    fn nothing_measured_is_an_empty_chart() {
        let svg = svg(&summary(&[], Better::Less), "");
        assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"), "{svg}");
    }

    #[test]
    fn axes_keep_the_order_of_values() {
        let mut quantity = summary(&[], Better::Less).error;
        quantity.logarithmic_from = Some(0.1);
        let axis = Axis::new(quantity, [0.0, 1.0, 1000.0].into_iter());
        let at = |value| axis.map(&value, (0, 1000));
        assert!(at(0.0) == at(0.1) && at(0.1) < at(1.0) && at(1.0) < at(1000.0));
        assert!(at(0.0) > 0 && at(1000.0) < 1000);
        let ticks = axis.key_points(10);
        assert_eq!(ticks, [0.1, 1.0, 10.0, 100.0, 1000.0]);
        let short = Axis::new(quantity, [2.1, 4.8].into_iter());
        assert_eq!(short.key_points(10), [2.0, 3.0, 4.0, 5.0]);
    }
}

//! What a user chooses between: each setting of a plugin as one error and one cost, over all scenes
//! of its study. Charts, tables and advice are made of it.

use std::collections::BTreeMap;

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
}

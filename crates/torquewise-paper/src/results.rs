//! What an experiment found, as plain data: tables and claims to save, charts to look at.

use crate::{PaperError, Settings};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Display;
use torquewise_report::{Chart, Heading, Label, chart_figure, html, significant};

/// All experiments.
///
/// Of the same settings everything is the same at any number of threads, but for computing times,
/// which stand under keys named `seconds`.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// What was done.
    pub settings: Settings,
    /// What was found, in the order of the paper, then beyond it.
    pub studies: Vec<Study>,
}

/// One experiment.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Study {
    /// What it is about, with the figures of the paper.
    pub heading: String,
    /// How to read it; may be empty.
    pub text: String,
    /// Claims of the paper that it judges.
    pub claims: Vec<Claim>,
    /// What was measured.
    pub tables: Vec<ResultTable>,
    /// What rests on computing time.
    #[serde(rename = "seconds")]
    pub timed: Timed,
    /// What is drawn.
    #[serde(skip_serializing)]
    pub figures: Vec<Figure>,
}

impl Study {
    /// The study of that name in `studies.toml`, before anything is measured.
    pub(crate) fn described(name: &str, n_joints: usize) -> Self {
        let all: Result<BTreeMap<String, Self>, _> = toml::from_str(include_str!("studies.toml"));
        let mut study = all.ok().and_then(|mut all| all.remove(name)).unwrap_or_default();
        for ResultTable { columns, joints, .. } in &mut study.tables {
            let each = |what| (1..=n_joints).map(move |joint| format!("{what}, joint {joint}"));
            columns.extend(joints.iter().flat_map(each));
        }
        study
    }
}

/// Claims and tables of computing times, which differ from run to run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
#[expect(missing_docs, reason = "as those of a study")]
pub struct Timed {
    pub claims: Vec<Claim>,
    pub tables: Vec<ResultTable>,
}

/// A claim of the paper, judged by what was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// What the paper says.
    pub claim: String,
    /// Where it says so.
    pub source: String,
    /// What is measured here.
    pub measured: String,
    /// Whether it holds.
    #[serde(skip_deserializing)]
    pub verdict: ClaimVerdict,
}

impl Claim {
    /// Says what is measured; the claim holds if all tests are passed, in part if any is.
    pub(crate) fn judge(&mut self, values: impl IntoIterator<Item = impl Display>, tests: &[bool]) {
        for value in values {
            self.measured = self.measured.replacen("{}", &value.to_string(), 1);
        }
        self.verdict = match (tests.contains(&true), tests.contains(&false)) {
            (true, false) => ClaimVerdict::Holds,
            (true, true) => ClaimVerdict::HoldsInPart,
            (false, _) => ClaimVerdict::Contradicted,
        };
    }
}

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClaimVerdict {
    /// As it stands.
    Holds,
    /// Under a condition that the measurement names.
    HoldsInPart,
    /// The measurement says otherwise.
    #[default]
    Contradicted,
}

impl ClaimVerdict {
    /// As one reads it.
    pub fn name(self) -> &'static str {
        ["holds", "holds in part", "contradicted"][self as usize]
    }
}

/// Rows under headings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultTable {
    /// What it shows.
    pub caption: String,
    /// Its headings.
    pub columns: Vec<String>,
    /// What is under them.
    #[serde(skip_deserializing)]
    pub rows: Vec<Vec<Cell>>,
    #[serde(default, skip_serializing)]
    joints: Vec<String>,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "as their names say")]
pub enum Cell {
    Text(String),
    Count(usize),
    Number(f64),
    Spread(Spread),
}

impl Cell {
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(number) => significant(*number, 3),
            Self::Spread(Spread { median, least, greatest }) => {
                let [middle, low, high] = [*median, *least, *greatest].map(|x| significant(x, 2));
                if low == high { middle } else { format!("{middle} ({low}–{high})") }
            }
        }
    }
}

macro_rules! cells {
    ($($kind:ident $from:ty),*) => {
        $(impl From<$from> for Cell {
            fn from(value: $from) -> Self {
                Self::$kind(value.into())
            }
        })*
    };
}
cells!(Text &str, Text String, Count usize, Number f64, Spread Spread);

impl ResultTable {
    /// Adds a row of some cells, then others of one kind.
    pub(crate) fn push(&mut self, head: &[Cell], rest: impl IntoIterator<Item = impl Into<Cell>>) {
        self.rows.push(head.iter().cloned().chain(rest.into_iter().map(Into::into)).collect());
    }

    pub(crate) fn to_html(&self) -> html::Table {
        let columns = self.columns.iter().enumerate().map(|(place, heading)| {
            let numeric =
                self.rows.iter().all(|row| !matches!(row.get(place), Some(Cell::Text(_))));
            if numeric { Heading::numbers(heading) } else { Heading::words(heading) }
        });
        let row = |row: &Vec<Cell>| row.iter().map(|cell| Label::from(cell.text())).collect();
        html::Table {
            caption: self.caption.clone(),
            columns: columns.collect(),
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

/// Charts that belong together.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Figure {
    /// Name of its file, without the ending.
    pub name: String,
    /// What is seen in it.
    pub caption: String,
    /// Its charts.
    #[serde(skip)]
    pub charts: Vec<Chart>,
}

impl Figure {
    /// The figure as an SVG text.
    ///
    /// # Errors
    /// [`PaperError::Report`] if it cannot be drawn.
    pub fn svg(&self) -> Result<String, PaperError> {
        Ok(chart_figure(&self.caption, &self.charts, self.columns())?)
    }

    pub(crate) fn columns(&self) -> usize {
        if self.charts.len() == 2 { 2 } else { 1 }
    }
}

impl Results {
    /// The results as JSON, one object.
    ///
    /// # Errors
    /// [`PaperError::Json`] if they cannot be written.
    pub fn to_json(&self) -> Result<String, PaperError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// All claims, those that rest on computing time among them.
    pub fn claims(&self) -> impl Iterator<Item = &Claim> {
        self.studies.iter().flat_map(|study| study.claims.iter().chain(&study.timed.claims))
    }

    /// All figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.studies.iter().flat_map(|study| &study.figures)
    }
}

/// How repeated values lie.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The value in the middle; the mean of the two there if the count is even.
    pub median: f64,
    /// The smallest.
    pub least: f64,
    /// The largest.
    pub greatest: f64,
}

impl Spread {
    /// The spread of some values; not a number if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        let at = |place: usize| sorted.get(place).copied().unwrap_or(f64::NAN);
        let median = 0.5 * (at(last / 2) + at(last.div_ceil(2)));
        Self { median, least: at(0), greatest: at(last) }
    }

    /// The spread of each column of some rows of the same length.
    pub fn of_columns<'a>(rows: impl IntoIterator<Item = &'a [f64]>) -> Vec<Self> {
        let rows: Vec<&[f64]> = rows.into_iter().collect();
        let columns = rows.first().map_or(0, |row| row.len());
        (0..columns).map(|j| Self::of(rows.iter().filter_map(|row| row.get(j)).copied())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_count_lies_between_the_middle_two() {
        let spread = Spread::of([4.0, 1.0, 3.0, 2.0]);

        assert_eq!(spread, Spread { median: 2.5, least: 1.0, greatest: 4.0 });
        assert!(Spread::of([]).median.is_nan());
        assert_eq!(Spread::of_columns([&[4.0][..], &[1.0], &[3.0], &[2.0]]), [spread]);
    }
}

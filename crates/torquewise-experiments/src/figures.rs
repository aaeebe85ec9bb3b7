//! From results to figures: those of the paper, and those beyond it.

pub(crate) mod looks;
mod patterns;
mod orders;
mod cost;
mod cases;
mod steps;
mod control;
mod beyond;

use crate::results::Results;
use torquewise_report::html::{Chart, Item};
use torquewise_report::{ReportError, chart_figure};

/// A figure: charts that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of its file, without the ending.
    pub name: String,
    /// What stands above it.
    pub title: String,
    /// What is seen in it.
    pub caption: String,
    /// Its charts.
    pub charts: Vec<Chart>,
    /// How many stand side by side.
    pub columns: usize,
}

impl Figure {
    /// The figure as an SVG text.
    ///
    /// # Errors
    /// [`ReportError`] if it cannot be drawn.
    pub fn svg(&self) -> Result<String, ReportError> {
        chart_figure(&self.title, &self.charts, self.columns)
    }

    /// The figure as parts of a page: caption and charts.
    pub fn items(&self) -> Vec<Item> {
        let mut items = vec![Item::Text(self.caption.clone())];
        if self.columns > 1 {
            items.push(Item::Charts(self.charts.clone()));
        } else {
            items.extend(self.charts.iter().cloned().map(|chart| Item::Charts(vec![chart])));
        }
        items
    }
}

/// All figures, in the order of the paper, then those beyond it.
pub fn figures(results: &Results) -> Vec<Figure> {
    let mut all = patterns::figures(&results.patterns);
    all.push(orders::figure(&results.orders));
    all.push(cost::figure(&results.costs));
    all.extend(cases::figures(results));
    all.extend(steps::figure(results));
    all.extend(control::figures(&results.control));
    all.extend(beyond::figures(results));
    all
}

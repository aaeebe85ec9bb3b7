//! From results to HTML report: one file that says what was done, what is seen and what holds.

mod cells;
mod summary;
mod setup;
mod paper;
mod control;
mod ablation;
mod beyond;

use crate::error::ExperimentError;
use crate::figures::{Figure, figures};
use crate::results::Results;
use torquewise_report::html::{Item, Page};

/// The report as one HTML text that needs no other file and no network.
///
/// # Errors
/// [`ExperimentError::Report`] if the page cannot be written.
pub fn page(results: &Results) -> Result<String, ExperimentError> {
    let drawn = Drawn(figures(results));
    let mut sections = vec![summary::section(results), setup::section(results)];
    sections.extend(paper::sections(results, &drawn));
    sections.push(control::section(&results.control, &drawn));
    sections.push(ablation::section(results));
    sections.extend(beyond::sections(results, &drawn));
    let page = Page {
        title: "Stepwise model reconstruction, simulated again".into(),
        lead: summary::lead(results),
        sections,
        ..Page::default()
    };
    Ok(page.to_html()?)
}

/// The figures, to be found by name.
struct Drawn(Vec<Figure>);

impl Drawn {
    /// Caption and charts of a figure; nothing if it was not drawn.
    fn items(&self, name: &str) -> Vec<Item> {
        let found = self.0.iter().find(|figure| figure.name == name);
        found.map_or_else(Vec::new, Figure::items)
    }
}

//! Page → HTML text: title, contents, sections, style and script in one file.

use crate::error::ReportError;
use crate::html::colour;
use crate::html::item::{Item, Writer};
use minijinja::{Environment, UndefinedBehavior, Value, context};

/// A page: sections under a title.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// What stands above it and names its window.
    pub title: String,
    /// One paragraph below the title; may be empty.
    pub lead: String,
    /// Its sections, from above.
    pub sections: Vec<Section>,
}

/// Parts under a heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// What stands above it, and in the contents.
    pub heading: String,
    /// Its parts, from above.
    pub items: Vec<Item>,
}

const PAGE: &str = include_str!("../assets/page.html");
const ITEM: &str = include_str!("../assets/item.html");
const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");
const CHART_STYLE: &str = include_str!("../assets/uPlot.min.css");
const CHART_SCRIPT: &str = include_str!("../assets/uPlot.iife.min.js");
const CHART_LICENCE: &str = include_str!("../assets/uPlot-LICENSE.txt");

impl Page {
    /// The page as one HTML text that needs no other file and no network.
    ///
    /// Checked against: `tests/report/browser.rs`, in a real browser.
    ///
    /// # Errors
    /// [`ReportError::Page`] if a template cannot be filled.
    pub fn to_html(&self) -> Result<String, ReportError> {
        self.write().map_err(|error| match error {
            Failure::Report(error) => error,
            Failure::Template(error) => ReportError::Page { reason: error.to_string() },
        })
    }

    fn write(&self) -> Result<String, Failure> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
        environment.add_template("page.html", PAGE)?;
        environment.add_template("item.html", ITEM)?;

        let mut writer = Writer::new(&environment);
        let mut sections = Vec::with_capacity(self.sections.len());
        for section in &self.sections {
            let body = Value::from_safe_string(writer.write(&section.items)?);
            sections.push(context! { heading => section.heading.as_str(), body });
        }
        let page = environment.get_template("page.html")?;
        let html = page.render(context! {
            title => self.title.as_str(),
            lead => self.lead.as_str(),
            sections,
            light => Value::from_safe_string(colour::light()),
            dark => Value::from_safe_string(colour::dark()),
            style => Value::from_safe_string([CHART_STYLE, STYLE].join("\n")),
            chart_licence => Value::from_safe_string(CHART_LICENCE.to_owned()),
            chart_script => Value::from_safe_string(CHART_SCRIPT.to_owned()),
            script => Value::from_safe_string(SCRIPT.to_owned()),
        })?;
        Ok(html)
    }
}

/// Why a page is not written, before it is put in words.
enum Failure {
    Report(ReportError),
    Template(minijinja::Error),
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        Self::Report(error)
    }
}

impl From<minijinja::Error> for Failure {
    fn from(error: minijinja::Error) -> Self {
        Self::Template(error)
    }
}

#[cfg(test)]
mod tests;

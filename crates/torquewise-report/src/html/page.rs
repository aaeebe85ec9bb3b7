//! The page: title, contents, sections, style and script in one file.

use crate::html::item::{Item, Writer};
use crate::{Result, safe};
use minijinja::{Environment, UndefinedBehavior, context};

/// A page: sections under a title.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// What stands above it and names its window.
    pub title: String,
    /// One paragraph below the title; may be empty.
    pub lead: String,
    /// Its sections, from above.
    pub sections: Vec<Section>,
    /// Where it comes from, line by line, at its foot.
    pub foot: Vec<String>,
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
pub(crate) const LIGHT: &str = include_str!("../assets/light.css");
pub(crate) const DARK: &str = include_str!("../assets/dark.css");
const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");
const SKELETON_SCRIPT: &str = include_str!("../assets/skeleton.js");
const CHART_STYLE: &str = include_str!("../assets/uPlot.min.css");
const CHART_SCRIPT: &str = include_str!("../assets/uPlot.iife.min.js");
const CHART_LICENCE: &str = include_str!("../assets/uPlot-LICENSE.txt");

impl Page {
    /// The page as one HTML text that needs no other file and no network.
    ///
    /// Checked against: `python/tests/test_report_page.py`, in a real browser.
    ///
    /// # Errors
    /// `ReportError::Page` or `ReportError::Data` if a template cannot be filled.
    pub fn to_html(&self) -> Result<String> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
        environment.add_template("page.html", PAGE)?;
        environment.add_template("item.html", ITEM)?;

        let mut writer = Writer { environment: &environment, charts: 0 };
        let mut sections = Vec::with_capacity(self.sections.len());
        for section in &self.sections {
            let body = safe(&writer.write(&section.items)?);
            sections.push(context! { heading => section.heading.as_str(), body });
        }
        let filled = context! {
            title => self.title.as_str(),
            lead => self.lead.as_str(),
            sections,
            foot => &self.foot,
            light => safe(LIGHT),
            dark => safe(DARK),
            style => safe(&[CHART_STYLE, STYLE].join("\n")),
            chart_licence => safe(CHART_LICENCE),
            chart_script => safe(CHART_SCRIPT),
            script => safe(&[SKELETON_SCRIPT, SCRIPT].join("\n")),
        };
        Ok(environment.get_template("page.html")?.render(filled)?)
    }
}

#[cfg(test)]
mod tests;

//! One part of a section as HTML.

use crate::html::bars::Bars;
use crate::html::chart::Chart;
use crate::html::colour::Colour;
use crate::html::equation::Equation;
use crate::html::skeleton::Skeleton;
use crate::html::spec::spec_json;
use crate::html::table::Table;
use crate::{Result, safe, script_json};
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use serde::Serialize;

/// One part of a section.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Item {
    /// A paragraph.
    Text(String),
    /// A box that is seen first.
    Callout {
        /// What it wants.
        tone: Tone,
        /// One word or two in large type; may be empty.
        heading: String,
        /// Its words, each a paragraph or, if they are several, a line of a list.
        lines: Vec<String>,
    },
    /// A table.
    Table(Table),
    /// Charts, several of them side by side where there is room.
    Charts(Vec<Chart>),
    /// Bars with names, likewise.
    Bars(Vec<Bars>),
    /// A chain of joints that can be played and rotated.
    Skeleton {
        /// Its axes and their motion.
        skeleton: Skeleton,
        /// How to read it.
        caption: String,
    },
    /// An equation.
    Equation(Equation),
    /// Parts that are shown when asked for, and always on paper.
    Details {
        /// What they hold.
        summary: String,
        /// The parts.
        items: Vec<Item>,
    },
}

/// What a box wants of its reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// To be careful.
    Warning,
    /// To be at ease.
    Good,
    /// To know.
    Note,
}

/// Writes items one after the other, and numbers the charts.
pub(crate) struct Writer<'a> {
    pub(crate) environment: &'a Environment<'a>,
    pub(crate) charts: usize,
}

impl Writer<'_> {
    pub(crate) fn write(&mut self, items: &[Item]) -> Result<String> {
        items.iter().map(|item| self.item(item)).collect()
    }

    fn item(&mut self, item: &Item) -> Result<String> {
        let (kind, item) = match item {
            Item::Text(text) => ("text", context! { text => text.as_str() }),
            Item::Callout { tone, heading, lines } => {
                ("callout", context! { tone => Serde(tone), heading, lines })
            }
            Item::Table(table) => {
                let (caption, columns) = (table.caption.as_str(), Serde(&table.columns));
                ("table", context! { caption, columns, rows => table.cells() })
            }
            Item::Charts(all) => {
                let charts: Result<Vec<_>, _> = all.iter().map(|c| self.chart(c)).collect();
                ("charts", context! { charts => charts?, beside => all.len() > 1 })
            }
            Item::Bars(bars) => {
                let all: Vec<_> = bars.iter().map(Bars::view).collect();
                ("bars", context! { all, beside => bars.len() > 1 })
            }
            Item::Skeleton { skeleton, caption } => {
                let label = format!("Axes of {}", skeleton.joints.join(", "));
                ("skeleton", context! { spec => safe(&script_json(skeleton)?), label, caption })
            }
            Item::Equation(equation) => ("equation", equation.view()),
            Item::Details { summary, items } => {
                let body = safe(&self.write(items)?);
                ("details", context! { summary => summary.as_str(), body })
            }
        };
        Ok(self.environment.get_template("item.html")?.render(context! { kind, item })?)
    }

    fn chart(&mut self, chart: &Chart) -> Result<Value> {
        self.charts += 1;
        let series: Vec<_> = chart
            .series
            .iter()
            .map(|s| key(&s.label, s.colour, Value::from(Serde(s.mark))))
            .collect();
        let guides = chart.guides.iter().filter(|guide| !guide.label.is_empty());
        let guides = guides.map(|guide| key(&guide.name(), Colour::Faded, Value::from("dashed")));
        let bands =
            chart.bands.iter().map(|band| key(&band.label, band.colour, Value::from("band")));
        let bands: Vec<_> = bands.chain(guides).collect();
        Ok(context! {
            number => self.charts,
            title => chart.title.as_str(),
            caption => chart.caption.as_str(),
            y_label => chart.y.label.as_str(),
            series,
            bands,
            spec => safe(&spec_json(chart)?),
        })
    }
}

fn key(label: &str, colour: Colour, mark: Value) -> Value {
    context! { label, colour => colour.variable(), mark }
}

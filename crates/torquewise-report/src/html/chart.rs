//! Charts: what is drawn, and how it is to be read.

use crate::html::colour::Colour;
use serde::Serialize;

/// A chart that its reader can zoom into by dragging, and read out by pointing.
///
/// Long curves are thinned to 4 000 points with their peaks, clouds evenly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// What stands above it.
    pub title: String,
    /// What stands below it: how to read it; may be empty.
    pub caption: String,
    /// To the right.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// What is drawn, the first at the back.
    pub series: Vec<Series>,
    /// Stretches of x coloured behind the curves.
    pub bands: Vec<Stretches>,
    /// Straight dashed lines.
    pub guides: Vec<Guide>,
    /// Charts with the same word here share the cursor and the zoom of x.
    pub linked: Option<String>,
}

impl Chart {
    /// Series over axes that are as long as they need, x and y.
    pub fn new(title: impl Into<String>, [x, y]: [Axis; 2], series: Vec<Series>) -> Self {
        Self { title: title.into(), x, y, series, ..Self::default() }
    }

    /// The same over linear axes of these names.
    pub fn over(title: impl Into<String>, names: [&str; 2], series: Vec<Series>) -> Self {
        Self::new(title, names.map(Axis::named), series)
    }
}

/// One axis of a chart.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Axis {
    /// What it is, with the unit in brackets.
    pub label: String,
    /// Whether equal steps are equal ratios; what is not positive is then not drawn.
    pub log: bool,
    /// Ends; `None` for what the points need.
    pub range: Option<[f64; 2]>,
    /// Names of the places 0, 1, 2, … instead of numbers; empty for numbers.
    pub places: Vec<String>,
    /// Whether only whole numbers stand at it: for what is counted.
    pub whole: bool,
}

impl Axis {
    /// A linear axis as long as its points need.
    pub fn named(label: impl Into<String>) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// A logarithmic axis as long as its points need.
    pub fn log(label: impl Into<String>) -> Self {
        Self { log: true, ..Self::named(label) }
    }

    /// A linear axis with whole numbers only.
    pub fn whole(label: impl Into<String>) -> Self {
        Self { whole: true, ..Self::named(label) }
    }
}

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// A thin line from left to right.
    #[default]
    Line,
    /// A broad line, for what others are compared with.
    #[serde(rename = "broad")]
    BroadLine,
    /// A dashed line.
    #[serde(rename = "dashed")]
    DashedLine,
    /// A line with a dot at each point.
    #[serde(rename = "dotted")]
    DottedLine,
    /// A cloud of dots.
    Cloud,
    /// Large rings.
    Rings,
    /// Bars from zero, as broad as the points are apart.
    Bars,
}

impl Mark {
    /// Whether points are joined from left to right, so that peaks matter more than density.
    pub(crate) fn is_line(self) -> bool {
        !matches!(self, Self::Cloud | Self::Rings)
    }
}

/// Points of one colour and name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub label: String,
    /// Its colour.
    pub colour: Colour,
    /// How it is drawn.
    pub mark: Mark,
    /// Its points (x, y) in any order. A y that is not finite is a gap; a point without x is none.
    pub points: Vec<[f64; 2]>,
    /// Lower and upper end of the error bar of each point; empty for none.
    pub spread: Vec<[f64; 2]>,
}

impl Series {
    /// A thin line in the first colour.
    pub fn line(label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self::new(label, Mark::Line, Colour::Series(0), points)
    }

    /// Points without error bars.
    pub fn new(
        label: impl Into<String>,
        mark: Mark,
        colour: Colour,
        points: Vec<[f64; 2]>,
    ) -> Self {
        Self { label: label.into(), colour, mark, points, spread: Vec::new() }
    }
}

/// Stretches of x with one meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretches {
    /// Its name in the legend.
    pub label: String,
    /// Its colour, of which a tint is drawn.
    pub colour: Colour,
    /// From where to where, in units of x.
    pub spans: Vec<[f64; 2]>,
}

/// A dashed line through the whole chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// What it marks, in the legend with its place; may be empty.
    pub label: String,
    /// Where it is.
    pub at: f64,
    /// Whether it is level, at a y, and not upright, at an x.
    pub is_level: bool,
}

impl Guide {
    /// An upright line at an x.
    pub fn at_x(x: f64, label: impl Into<String>) -> Self {
        Self { label: label.into(), at: x, is_level: false }
    }

    /// Its entry in the legend: what it marks, and where; empty if it has no label.
    pub(crate) fn name(&self) -> String {
        if self.label.is_empty() {
            return String::new();
        }
        let at: f64 = format!("{:.2e}", self.at).parse().unwrap_or(self.at);
        format!("{}: {at}", self.label)
    }

    /// A level line at a y.
    pub fn at_y(y: f64, label: impl Into<String>) -> Self {
        Self { label: label.into(), at: y, is_level: true }
    }
}

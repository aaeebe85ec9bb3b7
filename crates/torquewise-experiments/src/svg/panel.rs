//! Chart → panel: title, legend, axes, guides and marks.

use crate::svg::colour::{FADED, GRID, INK, hex};
use crate::svg::marks::Plane;
use crate::svg::scale::Scale;
use torquewise_report::html::chart::Position;
use torquewise_report::html::markup::escape;
use torquewise_report::html::{Band, Chart, Guide};

/// Space between and around panels.
pub(crate) const PANEL_GAP: f64 = 20.0;
/// Space for the numbers and the label at the left.
const LEFT: f64 = 78.0;
const RIGHT: f64 = 24.0;
/// Space for numbers and label below.
const BOTTOM: f64 = 52.0;
const TITLE: f64 = 24.0;
const LEGEND_ROW: f64 = 18.0;
/// Height of the axes.
const AXES: f64 = 240.0;
/// Height of the axes of a panel that takes the whole width.
const WIDE_AXES: f64 = 190.0;
/// Panels wider than this take the whole width.
const WIDE: f64 = 700.0;
/// Width of a letter of the legend.
const LETTER: f64 = 6.6;

/// A chart and the room it has.
pub(crate) struct Panel<'a> {
    chart: &'a Chart,
    width: f64,
    /// Names with their colours and where they stand.
    legend: Vec<(String, &'static str, f64, f64)>,
}

impl<'a> Panel<'a> {
    pub(crate) fn new(chart: &'a Chart, width: f64) -> Self {
        let names = chart.bands.iter().map(|band| (&band.label, hex(band.colour)));
        let names = names.chain(chart.series.iter().map(|s| (&s.label, hex(s.colour))));
        let names: Vec<_> = names.filter(|(label, _)| !label.is_empty()).collect();
        let mut legend = Vec::new();
        let (mut x, mut row) = (0.0, 0.0);
        for (label, colour) in names.iter().filter(|_| names.len() > 1) {
            let long = 26.0 + LETTER * label.chars().count() as f64;
            if x > 0.0 && x + long > width - LEFT - RIGHT {
                (x, row) = (0.0, row + 1.0);
            }
            legend.push(((*label).clone(), *colour, x, row));
            x += long;
        }
        Self { chart, width, legend }
    }

    fn head(&self) -> f64 {
        let rows = self.legend.last().map_or(0.0, |(_, _, _, row)| row + 1.0);
        TITLE + LEGEND_ROW * rows + 10.0
    }

    fn axes_height(&self) -> f64 {
        if self.width > WIDE { WIDE_AXES } else { AXES }
    }

    /// Height of the whole panel.
    pub(crate) fn height(&self) -> f64 {
        self.head() + self.axes_height() + BOTTOM
    }

    /// The panel as SVG, its axes at the bottom of `height` pixels.
    pub(crate) fn draw(&self, number: usize, height: f64) -> String {
        let chart = self.chart;
        let (width, tall) = (self.width - LEFT - RIGHT, self.axes_height());
        let (x, y) = self.scales(width, tall);
        let plane = Plane { x: &x, y: &y, height: tall };
        let top = height - BOTTOM - tall;
        let mut text = self.heading();
        text += &format!("<g transform=\"translate({LEFT:.0} {top:.0})\">\n");
        text += &format!(
            "<clipPath id=\"panel{number}\"><rect x=\"0\" y=\"-4\" width=\"{width:.0}\" \
             height=\"{:.0}\"/></clipPath>\n",
            tall + 8.0
        );
        text += &self.axes(&x, &y, width, tall);
        text += &format!("<g clip-path=\"url(#panel{number})\">\n");
        text.extend(chart.bands.iter().map(|band| band_marks(band, &x, tall)));
        text.extend(chart.guides.iter().map(|guide| guide_marks(guide, &x, &y, width, tall)));
        text.extend(chart.series.iter().map(|series| plane.draw(series)));
        text + "</g>\n</g>\n"
    }

    fn scales(&self, width: f64, tall: f64) -> (Scale, Scale) {
        let chart = self.chart;
        let points = || chart.series.iter().flat_map(|series| &series.points);
        let spread = chart.series.iter().flat_map(|series| &series.spread).flatten();
        let guides = |upright: bool| {
            chart.guides.iter().filter_map(move |guide| match guide.at {
                Position::X(at) if upright => Some(at),
                Position::Y(at) if !upright => Some(at),
                _ => None,
            })
        };
        let xs = points().map(|point| point[0]).chain(guides(true));
        let ys = points().map(|point| point[1]).chain(spread.copied()).chain(guides(false));
        (Scale::new(&chart.x, xs, width), Scale::new(&chart.y, ys, tall))
    }

    fn heading(&self) -> String {
        let mut text = format!(
            "<text x=\"{LEFT:.0}\" y=\"16\" font-size=\"14\" fill=\"{INK}\">{}</text>\n",
            escape(&self.chart.title)
        );
        for (label, colour, x, row) in &self.legend {
            let (x, y) = (LEFT + x, TITLE + LEGEND_ROW * row + 10.0);
            text += &format!(
                "<rect x=\"{x:.0}\" y=\"{:.0}\" width=\"12\" height=\"8\" fill=\"{colour}\"/>\
                 <text x=\"{:.0}\" y=\"{y:.0}\" font-size=\"12\" fill=\"{FADED}\">{}</text>\n",
                y - 8.0,
                x + 16.0,
                escape(label)
            );
        }
        text
    }

    fn axes(&self, x: &Scale, y: &Scale, width: f64, tall: f64) -> String {
        let chart = self.chart;
        let small = format!("font-size=\"12\" fill=\"{FADED}\"");
        let places = || {
            let names = chart.x.places.iter().enumerate();
            names.filter_map(|(k, name)| Some((x.place(k as f64)?, name.clone()))).collect()
        };
        let x_ticks: Vec<(f64, String)> =
            if chart.x.places.is_empty() { x.ticks() } else { places() };
        let mut text = String::new();
        for (at, number) in x_ticks {
            text += &format!(
                "<path d=\"M{at:.1} 0V{tall:.0}\" stroke=\"{GRID}\"/>\
                 <text x=\"{at:.1}\" y=\"{:.0}\" text-anchor=\"middle\" {small}>{}</text>\n",
                tall + 17.0,
                escape(&number)
            );
        }
        for (at, number) in y.ticks() {
            let at = tall - at;
            text += &format!(
                "<path d=\"M0 {at:.1}H{width:.0}\" stroke=\"{GRID}\"/>\
                 <text x=\"-8\" y=\"{:.1}\" text-anchor=\"end\" {small}>{number}</text>\n",
                at + 4.0
            );
        }
        text + &format!(
            "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\" {small}>{}</text>\n\
             <text transform=\"translate(-58 {:.0}) rotate(-90)\" text-anchor=\"middle\" {small}>\
             {}</text>\n",
            width / 2.0,
            tall + 38.0,
            escape(&chart.x.label),
            tall / 2.0,
            escape(&chart.y.label)
        )
    }
}

fn band_marks(band: &Band, x: &Scale, tall: f64) -> String {
    let colour = hex(band.colour);
    let mark = |&[from, to]: &[f64; 2]| {
        let (left, right) = (x.place(from)?, x.place(to)?);
        let width = (right - left).max(0.5);
        Some(format!(
            "<rect x=\"{left:.1}\" y=\"0\" width=\"{width:.1}\" height=\"{tall:.0}\" \
             fill=\"{colour}\" fill-opacity=\"0.25\"/>\n"
        ))
    };
    band.spans.iter().filter_map(mark).collect()
}

fn guide_marks(guide: &Guide, x: &Scale, y: &Scale, width: f64, tall: f64) -> String {
    let line = match guide.at {
        Position::X(at) => x.place(at).map(|at| (format!("M{at:.1} 0V{tall:.0}"), at + 5.0, 12.0)),
        Position::Y(at) => y.place(at).map(|at| {
            let at = tall - at;
            (format!("M0 {at:.1}H{width:.0}"), 6.0, at - 5.0)
        }),
    };
    line.map_or_else(String::new, |(path, left, top)| {
        format!(
            "<path d=\"{path}\" stroke=\"{FADED}\" stroke-dasharray=\"5 4\"/>\
             <text x=\"{left:.0}\" y=\"{top:.0}\" font-size=\"12\" fill=\"{FADED}\">{}</text>\n",
            escape(&guide.label)
        )
    })
}

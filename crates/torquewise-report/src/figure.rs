//! From charts to SVG: the charts of the report as a figure of its own, words kept as words.

mod words;
mod ticks;
mod scale;
mod strokes;
mod marks;
mod names;
mod legend;
mod axes;
mod plot;
mod panel;

use crate::error::ReportError;
use crate::figure::panel::Panel;
use crate::figure::words::{Area, drawing, height_of, style, wrapped, write};
use crate::html::Chart;
use crate::palette::{INK, PAPER};
use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;
use plotters::style::text_anchor::{HPos, VPos};

/// Dots to a pixel. The library draws at whole dots only: with two of them slopes have no stairs
/// and lines may be one and a half pixels broad. All lengths in here are in dots.
const DOTS: i32 = 2;
/// Width of a figure.
const WIDTH: i32 = 1_000 * DOTS;
/// Narrower panels would hold nothing but numbers.
const MOST_COLUMNS: usize = 5;
/// Space around the title, and below the last panel.
const MARGIN: i32 = 20 * DOTS;
/// Size of the letters of the title, in pixels.
const TITLE: i32 = 20;

/// An SVG with one panel per chart, so many `columns` side by side, five at most.
///
/// The figure is 1000 pixels wide, on white paper. Curves are thinned to what can be seen, peaks
/// kept; what lies beyond the ends of an axis is cut off. A chart with several names has a legend.
/// Captions are not drawn.
///
/// ```
/// use torquewise_report::chart_figure;
/// use torquewise_report::html::{Axis, Chart, Series};
///
/// let error = vec![[0.0, 0.5], [0.01, 2.0], [0.1, 21.0]];
/// let chart = Chart {
///     x: Axis::named("noise [°]"),
///     y: Axis::log("error [%]"),
///     series: vec![Series::line("energy", error)],
///     ..Chart::default()
/// };
/// let figure = chart_figure("A test", &[chart.clone(), chart], 2)?;
/// assert!(figure.starts_with("<svg") && figure.contains("error [%]"));
/// # Ok::<(), torquewise_report::ReportError>(())
/// ```
///
/// # Errors
/// [`ReportError::Drawing`].
pub fn chart_figure(title: &str, charts: &[Chart], columns: usize) -> Result<String, ReportError> {
    let columns = columns.min(charts.len()).clamp(1, MOST_COLUMNS);
    let width = (WIDTH - MARGIN) / i32::try_from(columns).unwrap_or(WIDTH);
    let panels: Vec<Panel<'_>> = charts.iter().map(|chart| Panel::new(chart, width)).collect();
    let rows: Vec<Row<'_>> = panels.chunks(columns).map(Row::new).collect();
    let title = wrapped(title, TITLE, WIDTH - 2 * MARGIN);
    let head = MARGIN / 2 + height_of(&title, TITLE);
    let height = head + rows.iter().map(|row| row.height).sum::<i32>() + MARGIN;
    let mut svg = String::new();
    {
        let size = (WIDTH.unsigned_abs(), height.unsigned_abs());
        let page = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        page.fill(&PAPER).map_err(drawing)?;
        let heading = style(TITLE, INK, HPos::Left, VPos::Top);
        write(&page, &title, TITLE, &heading, (MARGIN, MARGIN / 2))?;
        let mut rest = page.split_vertically(head).1;
        for row in &rows {
            let (area, below) = rest.split_vertically(row.height);
            row.draw(&area, width)?;
            rest = below;
        }
        page.present().map_err(drawing)?;
    }
    Ok(in_pixels(&svg, height))
}

/// Panels side by side, their axes level.
struct Row<'a> {
    panels: &'a [Panel<'a>],
    head: i32,
    foot: i32,
    height: i32,
}

impl<'a> Row<'a> {
    fn new(panels: &'a [Panel<'a>]) -> Self {
        let most = |length: fn(&Panel<'a>) -> i32| panels.iter().map(length).max().unwrap_or(0);
        let (head, foot) = (most(Panel::head), most(Panel::foot));
        Self { panels, head, foot, height: head + most(Panel::axes_height) + foot }
    }

    fn draw(&self, area: &Area<'_>, width: i32) -> Result<(), ReportError> {
        let mut rest = area.clone();
        for panel in self.panels {
            let (own, right) = rest.split_horizontally(width);
            panel.draw(&own, self.head, self.foot)?;
            rest = right;
        }
        Ok(())
    }
}

/// The figure at its size in pixels; its inner lengths stay in dots.
fn in_pixels(svg: &str, height: i32) -> String {
    let drawn = format!("width=\"{WIDTH}\" height=\"{height}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", WIDTH / DOTS, height / DOTS);
    svg.replacen(&drawn, &shown, 1)
}

#[cfg(test)]
mod tests;

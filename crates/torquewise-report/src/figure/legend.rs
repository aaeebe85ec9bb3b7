//! From names of series, bands and guides to legend: rows of samples and words.

use crate::error::ReportError;
use crate::figure::DOTS;
use crate::figure::marks;
use crate::figure::scale::is_shown;
use crate::figure::words::{Area, SMALL, drawing, style, width};
use crate::html::{Chart, Colour, Mark, Series};
use crate::palette::FADED_INK;
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

const ROW: i32 = 18 * DOTS;
const SAMPLE: i32 = 22 * DOTS;
/// Half the height of what is drawn as a rectangle.
const HALF: i32 = 5 * DOTS;
const GAP: i32 = 6 * DOTS;
/// Space to the next entry.
const SPACE: i32 = 18 * DOTS;

/// What stands above the axes.
pub(crate) struct Legend {
    entries: Vec<Entry>,
}

struct Entry {
    label: String,
    colour: RGBColor,
    /// How its series is drawn; nothing for a band.
    mark: Option<Mark>,
    x: i32,
    row: i32,
}

impl Legend {
    /// The names of a chart that has several, in rows of some length.
    pub(crate) fn new(chart: &Chart, room: i32) -> Self {
        let bands = chart.bands.iter().map(|band| (band.label.clone(), band.colour, None));
        let guides =
            chart.guides.iter().map(|guide| (guide.name(), Colour::Faded, Some(Mark::DashedLine)));
        let always = bands.chain(guides).map(|entry| (entry, true));
        let series = chart.series.iter().map(|series| {
            ((series.label.clone(), series.colour, Some(series.mark)), has_points(chart, series))
        });
        let named = always.chain(series).filter(|((label, _, _), _)| !label.is_empty());
        let named: Vec<_> = named.collect();
        let mut entries = Vec::new();
        let (mut x, mut row) = (0, 0);
        // One that is left of several still has to be told from those that are not there.
        let is_needed = named.len() > 1;
        let shown = named.into_iter().filter(|(_, has_points)| is_needed && *has_points);
        for ((label, colour, mark), _) in shown {
            let length = SAMPLE + GAP + width(&label, SMALL);
            if x > 0 && x + length > room {
                (x, row) = (0, row + 1);
            }
            entries.push(Entry { label, colour: colour.on_paper(), mark, x, row });
            x += length + SPACE;
        }
        Self { entries }
    }

    /// Height of all rows.
    pub(crate) fn height(&self) -> i32 {
        self.entries.last().map_or(0, |entry| (entry.row + 1) * ROW)
    }

    /// Draws the rows, their upper left corner at `left` and `top`.
    pub(crate) fn draw(&self, area: &Area<'_>, left: i32, top: i32) -> Result<(), ReportError> {
        let words = style(SMALL, FADED_INK, HPos::Left, VPos::Center);
        for entry in &self.entries {
            let (x, y) = (left + entry.x, top + entry.row * ROW + ROW / 2);
            sample(area, entry, x, y)?;
            let at = (x + SAMPLE + GAP, y);
            area.draw_text(&entry.label, &words, at).map_err(drawing)?;
        }
        Ok(())
    }
}

/// Whether the axes can show any point of a series.
fn has_points(chart: &Chart, series: &Series) -> bool {
    let shown = |[x, y]: &[f64; 2]| is_shown(chart.x.log, *x) && is_shown(chart.y.log, *y);
    series.points.iter().any(shown)
}

fn sample(area: &Area<'_>, entry: &Entry, x: i32, y: i32) -> Result<(), ReportError> {
    let colour = entry.colour;
    let corners = [(x, y - HALF), (x + SAMPLE, y + HALF)];
    match entry.mark {
        None => marks::tint(area, colour, corners),
        Some(Mark::Bars) => marks::bar(area, colour, corners),
        Some(mark) => {
            marks::line(area, mark, colour, vec![(x, y), (x + SAMPLE, y)])?;
            marks::point(area, mark, colour, (x + SAMPLE / 2, y))
        }
    }
}

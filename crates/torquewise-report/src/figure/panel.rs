//! From chart to panel: title, legend, axes, grid, and what is drawn between them.

use crate::error::ReportError;
use crate::figure::DOTS;
use crate::figure::axes::scales;
use crate::figure::legend::Legend;
use crate::figure::names::Names;
use crate::figure::plot::{Plane, Plot};
use crate::figure::words::{Area, SMALL, drawing, height_of, style, wrapped, write};
use crate::html::Chart;
use crate::palette::{FADED_INK, GRID, INK};
use plotters::chart::ChartBuilder;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

/// Space for the numbers and the label at the left, at least.
const LEFT: i32 = 78 * DOTS;
const RIGHT: i32 = 24 * DOTS;
/// Space beside the label at the left.
const EDGE: i32 = 10 * DOTS;
/// Space for the label of an axis.
const LABEL: i32 = 22 * DOTS;
/// Length of a tick, and half the space between axis and numbers.
const TICK: i32 = 4 * DOTS;
/// Space for one row of numbers below the axis.
const NUMBERS: i32 = 26 * DOTS;
/// Space above the axes and below the panel.
const GAP: i32 = 10 * DOTS;
/// Size of the letters of the title, in pixels.
const TITLE: i32 = 14;
/// Height of the axes.
const AXES: i32 = 240 * DOTS;
/// Height of the axes of a panel that takes the whole width.
const WIDE_AXES: i32 = 190 * DOTS;
/// Panels wider than this take the whole width.
const WIDE: i32 = 700 * DOTS;

/// A chart and the room it has.
pub(crate) struct Panel<'a> {
    chart: &'a Chart,
    title: Vec<String>,
    legend: Legend,
    names: Option<Names>,
    left: i32,
    axes_width: i32,
    axes_height: i32,
}

impl<'a> Panel<'a> {
    /// The panel of a chart for a width.
    pub(crate) fn new(chart: &'a Chart, width: i32) -> Self {
        let axes_height = if width > WIDE { WIDE_AXES } else { AXES };
        let (_, y) = scales(chart, (width, axes_height));
        let left = LEFT.max(EDGE + LABEL + y.widest() + 2 * TICK);
        let axes_width = (width - left - RIGHT).max(10 * DOTS);
        let slots = i32::try_from(chart.x.places.len()).unwrap_or(i32::MAX).max(1);
        let names =
            (!chart.x.places.is_empty()).then(|| Names::new(&chart.x.places, axes_width / slots));
        let title = wrapped(&chart.title, TITLE, axes_width);
        let legend = Legend::new(chart, axes_width);
        Self { chart, title, legend, names, left, axes_width, axes_height }
    }

    /// Height of the axes.
    pub(crate) fn axes_height(&self) -> i32 {
        self.axes_height
    }

    /// Height of what stands above them.
    pub(crate) fn head(&self) -> i32 {
        GAP + height_of(&self.title, TITLE) + self.legend.height() + GAP
    }

    /// Height of what stands below them.
    pub(crate) fn foot(&self) -> i32 {
        self.labels() + GAP
    }

    fn labels(&self) -> i32 {
        let names = self.names.as_ref().map_or(NUMBERS, |names| 3 * TICK + names.height());
        names + if self.chart.x.label.is_empty() { 0 } else { LABEL }
    }

    /// Draws all of the panel, with so much space above and below its axes.
    pub(crate) fn draw(&self, area: &Area<'_>, head: i32, foot: i32) -> Result<(), ReportError> {
        let (x, y) = scales(self.chart, (self.axes_width, self.axes_height));
        let mut builder = ChartBuilder::on(area);
        builder.margin_top(head).margin_right(RIGHT).margin_bottom(foot - self.labels());
        builder.margin_left(EDGE).y_label_area_size(self.left - EDGE);
        builder.x_label_area_size(self.labels());
        let mut axes = builder.build_cartesian_2d(x, y).map_err(drawing)?;

        let numbers = style(SMALL, FADED_INK, HPos::Center, VPos::Center);
        let mut mesh = axes.configure_mesh();
        mesh.bold_line_style(GRID.stroke_width(2)).axis_style(GRID.stroke_width(2));
        mesh.label_style(numbers.clone()).axis_desc_style(numbers).set_all_tick_mark_size(TICK);
        mesh.x_desc(&self.chart.x.label).y_desc(&self.chart.y.label);
        if self.names.is_some() {
            mesh.disable_x_mesh().disable_x_axis();
        }
        mesh.draw().map_err(drawing)?;

        self.draw_between(axes.plotting_area())?;
        self.draw_around(area, axes.plotting_area(), head)
    }

    fn draw_between(&self, plane: &Plane<'_>) -> Result<(), ReportError> {
        let (chart, plot) = (self.chart, Plot::new(plane));
        chart.bands.iter().try_for_each(|band| plot.band(band))?;
        chart.guides.iter().try_for_each(|guide| plot.guide(guide))?;
        chart.series.iter().try_for_each(|series| plot.series(series))
    }

    /// Title, legend and names of places.
    fn draw_around(
        &self,
        area: &Area<'_>,
        plane: &Plane<'_>,
        head: i32,
    ) -> Result<(), ReportError> {
        let top = head - self.head() + GAP;
        let heading = style(TITLE, INK, HPos::Left, VPos::Top);
        write(area, &self.title, TITLE, &heading, (self.left, top))?;
        let top = top + height_of(&self.title, TITLE);
        self.legend.draw(area, self.left, top)?;
        let Some(names) = &self.names else { return Ok(()) };
        let x = plane.as_coord_spec().x_spec();
        let places = (0..self.chart.x.places.len()).map(|place| {
            let place = place as f64;
            let (left, _) = plane.map_coordinate(&(place, 1.0));
            let at = (left - area.get_base_pixel().0, head + self.axes_height + 2 * TICK);
            x.contains(place).then_some(at)
        });
        names.write(area, places)
    }
}

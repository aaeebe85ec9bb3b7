//! From bands, guides, series to marks between the axes.

use crate::error::ReportError;
use crate::figure::axes::half_bar;
use crate::figure::marks::{self, Dot};
use crate::figure::scale::Scale;
use crate::figure::strokes::strokes;
use crate::figure::words::Area;
use crate::html::chart::Position;
use crate::html::thin::{MOST_POINTS, Sorted, rows_of_cloud, rows_of_curves, sorted};
use crate::html::{Band, Guide, Mark, Series};
use crate::palette::FADED_INK;
use plotters::backend::SVGBackend;
use plotters::coord::cartesian::Cartesian2d;
use plotters::drawing::DrawingArea;
use plotters::style::RGBColor;

/// Dots of a cloud at most: each is an element of its own.
const MOST_DOTS: usize = 2_000;

/// The area between the axes, in their units.
pub(crate) type Plane<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<Scale, Scale>>;

/// Where bands, guides and series are drawn.
pub(crate) struct Plot<'a, 'b> {
    plane: &'a Plane<'b>,
    /// The same in dots.
    pub(crate) area: Area<'b>,
}

impl<'a, 'b> Plot<'a, 'b> {
    pub(crate) fn new(plane: &'a Plane<'b>) -> Self {
        Self { plane, area: plane.strip_coord_spec() }
    }

    /// The axis to the right.
    pub(crate) fn x(&self) -> &Scale {
        self.plane.as_coord_spec().x_spec()
    }

    /// The axis up.
    pub(crate) fn y(&self) -> &Scale {
        self.plane.as_coord_spec().y_spec()
    }

    /// Where values stand that the axes contain.
    pub(crate) fn dot(&self, x: f64, y: f64) -> Dot {
        let (left, top) = self.plane.get_base_pixel();
        let (x, y) = self.plane.map_coordinate(&(x, y));
        (x - left, y - top)
    }

    /// Tinted stretches of x.
    pub(crate) fn band(&self, band: &Band) -> Result<(), ReportError> {
        let (x, y) = (self.x(), self.y());
        let spans = band.spans.iter().filter(|span| !span.iter().any(|end| end.is_nan()));
        for span in spans {
            let [from, to] = span.map(|end| x.clamped(end));
            if from < to {
                let corners = [self.dot(from, y.value(0.0)), self.dot(to, y.value(1.0))];
                marks::tint(&self.area, band.colour.on_paper(), corners)?;
            }
        }
        Ok(())
    }

    /// The line of a guide.
    pub(crate) fn guide(&self, guide: &Guide) -> Result<(), ReportError> {
        let (x, y) = (self.x(), self.y());
        let ends = match guide.at {
            Position::X(at) if x.contains(at) => [0.0, 1.0].map(|end| self.dot(at, y.value(end))),
            Position::Y(at) if y.contains(at) => [0.0, 1.0].map(|end| self.dot(x.value(end), at)),
            _ => return Ok(()),
        };
        marks::guide(&self.area, FADED_INK, ends)
    }

    /// All marks of a series.
    pub(crate) fn series(&self, series: &Series) -> Result<(), ReportError> {
        let (x, y) = (self.x(), self.y());
        let colour = series.colour.on_paper();
        let Sorted { points, spread } = sorted(series, x.is_log());
        // What cannot be shown is a gap.
        let height = |&[_, at]: &[f64; 2]| y.share(at).map_or(f64::NAN, |_| at);
        let heights: Vec<f64> = points.iter().map(height).collect();
        let rows = if series.mark.is_line() {
            rows_of_curves(&[&heights], points.len(), MOST_POINTS)
        } else {
            rows_of_cloud(points.len(), MOST_DOTS)
        };
        for (row, ends) in rows.iter().filter_map(|row| Some((row, spread.get(*row)?))) {
            self.error_bar(colour, points[*row][0], *ends)?;
        }
        if series.mark == Mark::Bars {
            let half = half_bar(&points);
            return rows.iter().try_for_each(|row| self.bar(colour, points[*row], half));
        }
        let shares =
            rows.iter().map(|&row| Some([x.share(points[row][0])?, y.share(heights[row])?]));
        for stroke in strokes(shares) {
            let mut dots: Vec<Dot> =
                stroke.iter().map(|[left, up]| self.dot(x.value(*left), y.value(*up))).collect();
            // Many points of a long curve fall on the same dot.
            dots.dedup();
            marks::line(&self.area, series.mark, colour, dots)?;
        }
        let shown = rows.iter().map(|row| points[*row]);
        shown.filter(|[left, up]| x.contains(*left) && y.contains(*up)).try_for_each(
            |[left, up]| marks::point(&self.area, series.mark, colour, self.dot(left, up)),
        )
    }

    fn bar(&self, colour: RGBColor, [at, end]: [f64; 2], half: f64) -> Result<(), ReportError> {
        let (x, y) = (self.x(), self.y());
        let (from, to) = (x.clamped(at - half), x.clamped(at + half));
        if y.share(end).is_none() || from >= to {
            return Ok(());
        }
        let corners = [self.dot(from, y.clamped(0.0)), self.dot(to, y.clamped(end))];
        marks::bar(&self.area, colour, corners)
    }

    fn error_bar(&self, colour: RGBColor, at: f64, ends: [f64; 2]) -> Result<(), ReportError> {
        let (x, y) = (self.x(), self.y());
        let [low, high] = ends.map(|end| y.clamped(end));
        if !x.contains(at) || ends.iter().any(|end| end.is_nan()) || low >= high {
            return Ok(());
        }
        let has_cap = ends.map(|end| y.contains(end));
        marks::error_bar(&self.area, colour, [self.dot(at, low), self.dot(at, high)], has_cap)
    }
}

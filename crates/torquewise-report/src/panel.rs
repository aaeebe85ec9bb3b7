//! Curves of one joint → panel: axes, grid and lines.

use crate::curve::{Stroke, clipped};
use crate::error::ReportError;
use crate::palette::{FADED_INK, FONT, GRID, INK};
use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::element::{PathElement, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoFont, RGBColor, ShapeStyle};

/// Part of a page.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A panel before it is drawn.
pub(crate) struct Panel<'a> {
    /// What stands above its upper left corner.
    pub(crate) heading: String,
    /// What its abscissae are, if this panel is to say so.
    pub(crate) x_label: Option<&'a str>,
    /// Left and right end.
    pub(crate) x_range: [f64; 2],
    /// Lower and upper end; what lies beyond is cut off.
    pub(crate) y_range: [f64; 2],
    /// Lines with their look, the first at the back.
    pub(crate) lines: Vec<(Stroke, ShapeStyle)>,
}

/// Space for the numbers at the axes and their units, in pixels.
const LEFT: i32 = 64;
const BOTTOM: i32 = 30;
/// Space for the name of an axis.
const LABEL: i32 = 22;
/// Space for the heading of the panel.
const TOP: i32 = 34;
const RIGHT: i32 = 24;

impl Panel<'_> {
    /// Height of a panel whose axes span `inner` pixels.
    pub(crate) fn height(&self, inner: i32) -> i32 {
        inner + TOP + BOTTOM + if self.x_label.is_some() { LABEL } else { 0 }
    }

    /// Draws all of the panel.
    pub(crate) fn draw(&self, area: &Area<'_>) -> Result<(), ReportError> {
        let [left, right] = self.x_range;
        let [low, high] = self.y_range;
        let mut builder = ChartBuilder::on(area);
        let label_space = if self.x_label.is_some() { LABEL } else { 0 };
        builder.margin_top(TOP).margin_right(RIGHT);
        builder.x_label_area_size(BOTTOM + label_space).y_label_area_size(LEFT);
        let mut chart = builder.build_cartesian_2d(left..right, low..high).map_err(drawing)?;

        let numbers = (FONT, 13).into_font().color(&FADED_INK);
        let mut mesh = chart.configure_mesh();
        mesh.x_labels(11).y_labels(5).light_line_style(RGBColor(255, 255, 255).mix(0.0));
        mesh.bold_line_style(GRID).axis_style(GRID).label_style(numbers);
        mesh.y_label_formatter(&|value| tick(*value)).x_label_formatter(&|value| tick(*value));
        mesh.axis_desc_style((FONT, 13).into_font().color(&FADED_INK));
        if let Some(label) = self.x_label {
            mesh.x_desc(label);
        }
        mesh.draw().map_err(drawing)?;

        for (line, style) in &self.lines {
            for stroke in clipped(line, self.y_range) {
                let path = PathElement::new(stroke, *style);
                chart.draw_series(std::iter::once(path)).map_err(drawing)?;
            }
        }
        let heading = (FONT, 15).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Bottom));
        area.draw(&Text::new(self.heading.as_str(), (LEFT, TOP - 9), heading)).map_err(drawing)
    }
}

/// A number at an axis: no digits that say nothing.
fn tick(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    let plain = if rounded == 0.0 { 0.0 } else { rounded };
    if plain == 0.0 && value.abs() > 1e-12 { format!("{value:.0e}") } else { format!("{plain}") }
}

/// The drawing library's own error, in words.
pub(crate) fn drawing(error: impl std::fmt::Display) -> ReportError {
    ReportError::Drawing { reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::tick;

    #[test]
    fn a_tick_has_no_rounding_dust() {
        assert_eq!(tick(0.1 + 0.2), "0.3");
        assert_eq!(tick(-1e-17), "0");
        assert_eq!(tick(-40.0), "-40");
        assert_eq!(tick(2e-9), "2e-9");
    }
}

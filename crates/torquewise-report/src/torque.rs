//! Measured and predicted torque → figure: one panel per joint over time.

use crate::curve::{Stroke, thinned};
use crate::error::ReportError;
use crate::palette::{self, FADED_INK, FONT, INK, PAPER};
use crate::panel::{Area, Panel, drawing};
use faer::{ColRef, MatRef};
use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;
use plotters::element::{PathElement, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{IntoFont, ShapeStyle};

/// Width of the page in pixels.
const WIDTH: i32 = 1_000;
/// Height of the axes of a panel.
const PANEL: i32 = 150;
/// Space for title and legend.
const HEAD: i32 = 84;
/// Space below the last panel.
const FOOT: i32 = 10;
/// Left end of title and legend.
const MARGIN: i32 = 64;

/// An SVG with one panel per joint: measured torque, and on top of it each prediction.
///
/// A panel is as high as what was measured and a margin; a prediction that leaves it is cut off at
/// its edge, so that a bad one does not flatten the others. Long signals are thinned to what can
/// be seen, peaks kept.
///
/// - `joints`: names, n
/// - `t`: time stamps \[s\], m, strictly increasing
/// - `measured`: torque \[N·m\], m×n
/// - `predictions`: label and torque \[N·m\], m×n each
///
/// # Errors
/// [`ReportError::Empty`], [`ReportError::Shape`], [`ReportError::NotFinite`] or
/// [`ReportError::TimeOrder`] if the signals are no motion; [`ReportError::Drawing`].
pub fn torque_figure(
    title: &str,
    joints: &[String],
    t: &[f64],
    measured: MatRef<'_, f64>,
    predictions: &[(&str, MatRef<'_, f64>)],
) -> Result<String, ReportError> {
    check_time(t, joints.len())?;
    check("measured torque", measured, t.len(), joints.len())?;
    for (label, predicted) in predictions {
        check(label, *predicted, t.len(), joints.len())?;
    }
    let panels: Vec<Panel<'_>> = (0..joints.len())
        .map(|joint| Panel {
            heading: format!("{} torque [N·m]", joints[joint]),
            x_label: (joint + 1 == joints.len()).then_some("time [s]"),
            x_range: [t[0], t[t.len() - 1]],
            y_range: y_range(measured.col(joint)),
            lines: lines(t, joint, measured, predictions),
        })
        .collect();
    draw(title, predictions, &panels)
}

fn lines(
    t: &[f64],
    joint: usize,
    measured: MatRef<'_, f64>,
    predictions: &[(&str, MatRef<'_, f64>)],
) -> Vec<(Stroke, ShapeStyle)> {
    // The first prediction is the one to look at: it lies on top.
    let predicted = predictions
        .iter()
        .enumerate()
        .rev()
        .map(|(place, (_, torque))| (thinned(t, torque.col(joint)), palette::predicted(place)));
    std::iter::once((thinned(t, measured.col(joint)), palette::measured()))
        .chain(predicted)
        .collect()
}

/// Range of the measured torque and a margin.
fn y_range(measured: ColRef<'_, f64>) -> [f64; 2] {
    let low = measured.iter().copied().fold(f64::INFINITY, f64::min);
    let high = measured.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A torque that never changes still has a panel of some height.
    let margin = (0.15 * (high - low)).max(1e-3 * low.abs().max(high.abs())).max(1e-6);
    [low - margin, high + margin]
}

fn draw(
    title: &str,
    predictions: &[(&str, MatRef<'_, f64>)],
    panels: &[Panel<'_>],
) -> Result<String, ReportError> {
    let height = HEAD + FOOT + panels.iter().map(|panel| panel.height(PANEL)).sum::<i32>();
    let mut svg = String::new();
    {
        let size = (WIDTH.unsigned_abs(), height.unsigned_abs());
        let page = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        page.fill(&PAPER).map_err(drawing)?;
        let heading = (FONT, 20).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        page.draw(&Text::new(title, (MARGIN, 26), heading)).map_err(drawing)?;
        draw_legend(&page, predictions)?;
        let mut rest = page.split_vertically(HEAD).1;
        for panel in panels {
            let (area, below) = rest.split_vertically(panel.height(PANEL));
            panel.draw(&area)?;
            rest = below;
        }
        page.present().map_err(drawing)?;
    }
    Ok(svg)
}

/// A line and a label for each curve, in one row.
fn draw_legend(
    page: &Area<'_>,
    predictions: &[(&str, MatRef<'_, f64>)],
) -> Result<(), ReportError> {
    let predicted = predictions
        .iter()
        .enumerate()
        .map(|(place, (label, _))| (*label, palette::predicted(place)));
    let (sample, letter, y) = (30, 7, 58);
    let mut x = MARGIN;
    for (label, style) in std::iter::once(("measured", palette::measured())).chain(predicted) {
        let line = PathElement::new([(x, y), (x + sample, y)], style);
        page.draw(&line).map_err(drawing)?;
        let text = (FONT, 14).into_font().color(&FADED_INK);
        let text = text.pos(Pos::new(HPos::Left, VPos::Center));
        page.draw(&Text::new(label, (x + sample + 8, y), text)).map_err(drawing)?;
        let letters = i32::try_from(label.chars().count()).unwrap_or(i32::MAX / (2 * letter));
        x += sample + 8 + letters.min(WIDTH) * letter + 24;
    }
    Ok(())
}

fn check_time(t: &[f64], joints: usize) -> Result<(), ReportError> {
    if t.len() < 2 || joints == 0 {
        return Err(ReportError::Empty { rows: t.len(), joints });
    }
    if let Some(row) = t.iter().position(|t| !t.is_finite()) {
        return Err(ReportError::NotFinite { signal: "t".into(), row });
    }
    match t.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(before) => Err(ReportError::TimeOrder { row: before + 1 }),
        None => Ok(()),
    }
}

fn check(
    signal: &str,
    values: MatRef<'_, f64>,
    expected_rows: usize,
    expected_columns: usize,
) -> Result<(), ReportError> {
    let (rows, columns) = (values.nrows(), values.ncols());
    if (rows, columns) != (expected_rows, expected_columns) {
        let signal = signal.into();
        return Err(ReportError::Shape { signal, rows, columns, expected_rows, expected_columns });
    }
    let not_finite = |row: &usize| values.row(*row).iter().any(|value: &f64| !value.is_finite());
    match (0..rows).find(not_finite) {
        Some(row) => Err(ReportError::NotFinite { signal: signal.into(), row }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;

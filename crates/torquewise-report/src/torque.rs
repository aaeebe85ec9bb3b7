//! From measured and predicted torque to figure: one panel per joint over time.

use crate::error::ReportError;
use crate::figure::chart_figure;
use crate::html::{Axis, Chart, Colour, Mark, Series};
use faer::{ColRef, MatRef};

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
    let charts: Vec<Chart> =
        (0..joints.len()).map(|joint| chart(joints, joint, t, measured, predictions)).collect();
    chart_figure(title, &charts, 1)
}

fn chart(
    joints: &[String],
    joint: usize,
    t: &[f64],
    measured: MatRef<'_, f64>,
    predictions: &[(&str, MatRef<'_, f64>)],
) -> Chart {
    let curve = |label: &str, mark: Mark, colour: Colour, torque: MatRef<'_, f64>| {
        let points = t.iter().zip(torque.col(joint).iter()).map(|(t, tau)| [*t, *tau]).collect();
        // One legend for all panels, one name for their common axis.
        Series::new(if joint == 0 { label } else { "" }, mark, colour, points)
    };
    // The first prediction is the one to look at: it lies on top.
    let predicted =
        predictions.iter().enumerate().rev().map(|(place, (label, torque))| {
            curve(label, Mark::Line, Colour::Series(place), *torque)
        });
    let measured_curve = curve("measured", Mark::BroadLine, Colour::Measured, measured);
    Chart {
        title: joints[joint].clone(),
        x: Axis::named(if joint + 1 == joints.len() { "time [s]" } else { "" }),
        y: Axis { range: Some(y_range(measured.col(joint))), ..Axis::named("torque [N·m]") },
        series: std::iter::once(measured_curve).chain(predicted).collect(),
        ..Chart::default()
    }
}

/// Range of the measured torque and a margin.
fn y_range(measured: ColRef<'_, f64>) -> [f64; 2] {
    let low = measured.iter().copied().fold(f64::INFINITY, f64::min);
    let high = measured.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A torque that never changes still has a panel of some height.
    let margin = (0.15 * (high - low)).max(1e-3 * low.abs().max(high.abs())).max(1e-6);
    [low - margin, high + margin]
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

//! One look for all charts.

use crate::method::Method;
use faer::MatRef;
use torquewise_report::html::{Axis, Chart, Colour, Mark, Series};

/// The colour of a method in every chart.
pub(crate) fn colour(method: Method) -> Colour {
    Colour::Series(match method {
        Method::Energy => 0,
        Method::Sindy => 1,
        Method::Product => 2,
        Method::SindyLasso => 3,
        Method::SindyCriterion => 4,
    })
}

/// Values over time or speed.
pub(crate) fn points(x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
    x.iter().zip(y).map(|(&x, &y)| [x, y]).collect()
}

/// Name, colour and torque of each joint of what is drawn, n×m.
pub(crate) type Line = (String, Colour, Vec<Vec<f64>>);

/// Torque over time, a chart of each joint: what is needed, and what is predicted of it.
///
/// The axis is that of what is needed, with a margin, so that a bad prediction does not flatten it.
pub(crate) fn torque_charts(
    t: &[f64],
    needed: &[Vec<f64>],
    predicted: &[Line],
    linked: &str,
) -> Vec<Chart> {
    let chart = |(joint, needed): (usize, &Vec<f64>)| {
        let measured = Series::new("needed", Mark::BroadLine, Colour::Measured, points(t, needed));
        let others = predicted.iter().map(|(label, colour, torque)| {
            Series::new(label, Mark::Line, *colour, points(t, &torque[joint]))
        });
        let low = needed.iter().copied().fold(f64::INFINITY, f64::min);
        let high = needed.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let margin = (0.15 * (high - low)).max(1e-6);
        Chart {
            title: format!("Joint {}", joint + 1),
            x: Axis::named("time [s]"),
            y: Axis { range: Some([low - margin, high + margin]), ..Axis::named("torque [N·m]") },
            series: std::iter::once(measured).chain(others).collect(),
            linked: Some(linked.into()),
            ..Chart::default()
        }
    };
    needed.iter().enumerate().map(chart).collect()
}

/// Columns of a matrix, every so many rows.
pub(crate) fn columns(x: MatRef<'_, f64>, stride: usize) -> Vec<Vec<f64>> {
    x.col_iter().map(|column| column.iter().step_by(stride).copied().collect()).collect()
}

/// Label and colour of the torque after a step, counted from 0.
pub(crate) fn after_step(step: usize, name: &str) -> (String, Colour) {
    let colour = [Colour::Series(5), Colour::Series(2), Colour::Series(1)][step.min(2)];
    (format!("after step {}: {name}", step + 1), colour)
}

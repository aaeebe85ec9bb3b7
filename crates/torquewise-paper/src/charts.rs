//! One look for all charts.

use crate::method::Method;
use crate::trial::Step;
use faer::Mat;
use torquewise_motion::{Motion, MotionError};
use torquewise_report::html::{Axis, Chart, Colour, Series};

/// The colour of a method in every chart.
pub(crate) fn colour(method: Method) -> Colour {
    Colour::Series(method as usize)
}

/// Values over time or speed.
pub(crate) fn points(x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
    x.iter().zip(y).map(|(&x, &y)| [x, y]).collect()
}

/// A chart of some series over plain axes.
pub(crate) fn chart(title: impl Into<String>, [x, y]: [&str; 2], series: Vec<Series>) -> Chart {
    Chart { title: title.into(), x: Axis::named(x), y: Axis::named(y), series, ..Chart::default() }
}

/// Name, colour and torque of what is drawn, m×n.
pub(crate) type Line = (String, Colour, Mat<f64>);

/// Torque over time, every so many rows: what a motion takes, and what is predicted of it.
pub(crate) fn torque_charts(
    motion: &Motion,
    stride: usize,
    predicted: &[Line],
    linked: &str,
) -> Result<Vec<Chart>, MotionError> {
    let mut charts = torquewise_report::torque_charts(("needed", motion), stride, predicted)?;
    for chart in &mut charts {
        chart.linked = Some(linked.into());
    }
    Ok(charts)
}

/// The torque after each step.
pub(crate) fn step_lines(steps: Vec<Step>) -> Vec<Line> {
    let colours = [5, 2, 1].map(Colour::Series);
    let line = |(step, Step { name, torque, .. }): (usize, Step)| {
        (format!("after step {}: {name}", step + 1), colours[step.min(2)], torque)
    };
    steps.into_iter().enumerate().map(line).collect()
}

//! One look for all charts.

use crate::method::Method;
use crate::trial::Step;
use faer::Mat;
use torquewise_report::html::{Axis, Chart, Colour, Series};

/// The colour of a method in every chart.
pub(crate) fn colour(method: Method) -> Colour {
    Colour::Series(method as usize)
}

pub(crate) fn chart(title: impl Into<String>, [x, y]: [Axis; 2], series: Vec<Series>) -> Chart {
    Chart { title: title.into(), x, y, series, ..Chart::default() }
}

/// Name, colour and torque after each step, m×n.
pub(crate) fn step_lines(steps: Vec<Step>) -> Vec<(String, Colour, Mat<f64>)> {
    let colours = [5, 2, 1].map(Colour::Series);
    let line = |(step, Step { name, torque, .. }): (usize, Step)| {
        (format!("after step {}: {name}", step + 1), colours[step.min(2)], torque)
    };
    steps.into_iter().enumerate().map(line).collect()
}

//! One look for all charts.

use crate::method::Method;
use crate::trial::Step;
use faer::Mat;
use torquewise_report::html::Colour;

pub(crate) fn colour(method: Method) -> Colour {
    Colour::Series(method as usize)
}

/// Name, colour and torque after each step, m×n.
pub(crate) fn step_lines(steps: Vec<Step>) -> Vec<(String, Colour, Mat<f64>)> {
    let colours = [5, 2, 1].map(Colour::Series);
    let line = |(step, Step { name, torque, .. }): (usize, Step)| {
        (format!("after step {}: {name}", step + 1), colours[step.min(2)], torque)
    };
    steps.into_iter().enumerate().map(line).collect()
}

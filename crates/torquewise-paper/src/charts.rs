//! One look for all charts.

use crate::method::Method;
use crate::trial::Step;
use faer::{Mat, MatRef};
use torquewise_motion::{Motion, MotionError};
use torquewise_report::html::{Axis, Chart, Colour, Mark, Series};

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

/// Torque over time, a chart of each joint: what a motion takes, and what is predicted of it, every
/// so many rows.
///
/// The axis is that of what is needed, with a margin, so that a bad prediction does not flatten it.
pub(crate) fn torque_charts(
    motion: &Motion,
    stride: usize,
    predicted: &[Line],
    linked: &str,
) -> Result<Vec<Chart>, MotionError> {
    let t = motion.t().iter().step_by(stride);
    let needed = motion.require_tau()?;
    let of_joint = |joint: usize| {
        let over_time = |tau: MatRef<'_, f64>| -> Vec<[f64; 2]> {
            t.clone()
                .zip(tau.col(joint).iter().step_by(stride))
                .map(|(&t, &tau)| [t, tau])
                .collect()
        };
        let needed = over_time(needed);
        let low = needed.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        let high = needed.iter().map(|point| point[1]).fold(f64::NEG_INFINITY, f64::max);
        let margin = (0.15 * (high - low)).max(1e-6);
        let mut series = vec![Series::new("needed", Mark::BroadLine, Colour::Measured, needed)];
        series.extend(predicted.iter().map(|(label, colour, torque)| {
            Series::new(label, Mark::Line, *colour, over_time(torque.as_ref()))
        }));
        let title = format!("Joint {}", joint + 1);
        let mut chart = chart(title, ["time [s]", "torque [N·m]"], series);
        chart.y.range = Some([low - margin, high + margin]);
        Chart { linked: Some(linked.into()), ..chart }
    };
    Ok((0..motion.n_joints()).map(of_joint).collect())
}

/// The torque after each step.
pub(crate) fn step_lines(steps: Vec<Step>) -> Vec<Line> {
    let colours = [5, 2, 1].map(Colour::Series);
    let line = |(step, Step { name, torque, .. }): (usize, Step)| {
        (format!("after step {}: {name}", step + 1), colours[step.min(2)], torque)
    };
    steps.into_iter().enumerate().map(line).collect()
}

//! One look for all charts.

use crate::method::Method;
use crate::spread::Spread;
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

/// Medians with bars from the least to the greatest.
pub(crate) fn spread_series(
    method: Method,
    mark: Mark,
    points: impl Iterator<Item = (f64, Spread)>,
) -> Series {
    let (points, spread) = points.map(|(x, y)| ([x, y.median], [y.least, y.greatest])).unzip();
    Series { spread, ..Series::new(method.name(), mark, colour(method), points) }
}

/// Torque over time: what is needed, and what is predicted of it.
///
/// The axis is that of what is needed, with a margin, so that a bad prediction does not flatten it.
pub(crate) fn torque_chart<'a>(
    joint: usize,
    t: &[f64],
    needed: &[f64],
    predicted: impl Iterator<Item = (String, Colour, &'a [f64])>,
    linked: &str,
) -> Chart {
    let measured = Series::new("needed", Mark::BroadLine, Colour::Measured, points(t, needed));
    let others = predicted
        .map(|(label, colour, tau)| Series::new(label, Mark::Line, colour, points(t, tau)));
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
}

/// Label and colour of the torque after a step, counted from 0.
pub(crate) fn after_step(step: usize, name: &str) -> (String, Colour) {
    let colour = [Colour::Series(5), Colour::Series(2), Colour::Series(1)][step.min(2)];
    (format!("after step {}: {name}", step + 1), colour)
}

/// An axis of names.
pub(crate) fn places(label: &str, names: impl Iterator<Item = String>) -> Axis {
    Axis { places: names.collect(), ..Axis::named(label) }
}

//! From method, joint, spread to colour, mark and points: one look for all figures.

use crate::method::Method;
use crate::scenario::Decibels;
use crate::spread::Spread;
use torquewise_report::html::{Axis, Chart, Colour, Mark, Series};

/// The colour of a method in every figure.
pub(crate) fn colour(method: Method) -> Colour {
    Colour::Series(match method {
        Method::Energy => 0,
        Method::Sindy => 1,
        Method::Product => 2,
        Method::SindyLasso => 3,
        Method::SindyCriterion => 4,
    })
}

/// Medians with bars from the least to the greatest.
pub(crate) fn spread_series(
    label: &str,
    colour: Colour,
    mark: Mark,
    points: impl Iterator<Item = (f64, Spread)>,
) -> Series {
    let (points, spread) = points.map(|(x, y)| ([x, y.median], [y.least, y.greatest])).unzip();
    Series { spread, ..Series::new(label, mark, colour, points) }
}

/// The spread of the joint with the largest median.
pub(crate) fn worst_joint(joints: &[Spread]) -> Spread {
    let worst = joints.iter().copied().max_by(|a, b| a.median.total_cmp(&b.median));
    worst.unwrap_or(Spread::of([]))
}

/// Torque over time: what is needed, and what is predicted of it by its label and colour.
///
/// The axis is that of what is needed, with a margin, so that a bad prediction does not flatten it.
pub(crate) fn torque_chart<'a>(
    title: String,
    t: &[f64],
    (label, needed): (&str, &[f64]),
    predicted: impl Iterator<Item = (String, Colour, &'a [f64])>,
    linked: &str,
) -> Chart {
    let line = |values: &[f64]| t.iter().zip(values).map(|(&t, &tau)| [t, tau]).collect();
    let measured = Series::new(label, Mark::BroadLine, Colour::Measured, line(needed));
    let others =
        predicted.map(|(label, colour, tau)| Series::new(label, Mark::Line, colour, line(tau)));
    let low = needed.iter().copied().fold(f64::INFINITY, f64::min);
    let high = needed.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let margin = (0.15 * (high - low)).max(1e-6);
    Chart {
        title,
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

/// An axis of levels of noise, each once, and the place of any of them.
pub(crate) fn noise_axis(
    noise: impl Iterator<Item = Decibels>,
) -> (Axis, impl Fn(Decibels) -> usize) {
    let mut levels: Vec<Decibels> = Vec::new();
    for level in noise {
        if !levels.contains(&level) {
            levels.push(level);
        }
    }
    let names = levels.iter().map(Decibels::name);
    let axis = places("signal-to-noise ratio of q/dq/ddq", names);
    (axis, move |noise| levels.iter().position(|level| *level == noise).unwrap_or(0))
}

pub(crate) fn places(label: &str, names: impl Iterator<Item = String>) -> Axis {
    Axis { places: names.collect(), ..Axis::named(label) }
}

/// Marks of several series side by side about a place.
pub(crate) fn beside(place: usize, series: usize, count: usize) -> f64 {
    let middle = (count as f64 - 1.0) / 2.0;
    place as f64 + 0.6 * (series as f64 - middle) / count.max(1) as f64
}

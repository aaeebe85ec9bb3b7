//! From method, joint, spread to colour, mark and points: one look for all figures.

use crate::method::Method;
use crate::spread::Spread;
use torquewise_report::html::{Axis, Colour, Mark, Series};

/// The colour of a method in every figure.
pub fn colour(method: Method) -> Colour {
    Colour::Series(match method {
        Method::Energy => 0,
        Method::Sindy => 1,
        Method::Product => 2,
        Method::SindyLasso => 3,
        Method::SindyCriterion => 4,
    })
}

/// Medians with bars from the least to the greatest.
pub fn spread_series(
    label: &str,
    colour: Colour,
    mark: Mark,
    points: impl Iterator<Item = (f64, Spread)>,
) -> Series {
    let (points, spread) = points.map(|(x, y)| ([x, y.median], [y.least, y.greatest])).unzip();
    Series { spread, ..Series::new(label, mark, colour, points) }
}

/// The spread of the joint with the largest median.
pub fn worst_joint(joints: &[Spread]) -> Spread {
    let worst = joints.iter().copied().max_by(|a, b| a.median.total_cmp(&b.median));
    worst.unwrap_or(Spread::of([]))
}

/// An axis of names.
pub fn places(label: &str, names: impl Iterator<Item = String>) -> Axis {
    Axis { places: names.collect(), ..Axis::named(label) }
}

/// Marks of several series side by side about a place.
pub fn beside(place: usize, series: usize, count: usize) -> f64 {
    let middle = (count as f64 - 1.0) / 2.0;
    place as f64 + 0.6 * (series as f64 - middle) / count.max(1) as f64
}

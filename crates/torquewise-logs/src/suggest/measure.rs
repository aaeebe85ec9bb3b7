//! Usual step and ranges of a log, and its velocities against the slopes of positions.

use crate::accelerations::slopes;
use crate::preview::first_values;
use crate::profile::unit::of_step;
use crate::source::named_rows;
use crate::{LogInput, Result};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use torquewise_motion::{Signal, median};

/// Rows that are looked at closely.
const SAMPLE: usize = 20_000;

#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Measured {
    /// Median of the steps of the clock, in its own unit.
    pub(super) step: Option<f64>,
    pub(super) largest_q: Option<f64>,
    /// Velocity over slope of the position, where both are known.
    pub(super) ratio: Option<f64>,
}

/// The first rows of columns of a file.
pub(super) fn columns(file: &LogInput, names: &[String]) -> Result<Vec<Vec<f64>>> {
    let rows = named_rows(file)?;
    let place = |name: &String| rows.names().iter().position(|known| known == name);
    let chosen: Vec<usize> = names.iter().filter_map(place).collect();
    first_values(rows, &chosen, SAMPLE)
}

/// - `values`: columns of each signal, with the same rows as t
pub(super) fn measure(t: Option<&[f64]>, values: &BTreeMap<Signal, Vec<Vec<f64>>>) -> Measured {
    let of = |signal| values.get(&signal).map_or(&[][..], Vec::as_slice);
    let (q, dq) = (of(Signal::Q), of(Signal::Dq));
    let largest = q.iter().flatten().filter(|x| x.is_finite());
    let steps = t.unwrap_or_default().windows(2).map(|pair| pair[1] - pair[0]);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0 && step.is_finite()).collect();
    let step = (!steps.is_empty()).then(|| median(&mut steps));
    let seconds = step.map_or(1.0, |step| of_step(step).1);
    Measured {
        step,
        largest_q: largest.map(|x| x.abs()).reduce(f64::max),
        ratio: t.and_then(|t| ratio(t, seconds, q, dq)),
    }
}

/// Units of position and velocity that fit a ratio of velocity and slope to 10 %.
pub(super) fn units_of(ratio: f64) -> Option<(&'static str, &'static str)> {
    let known = [
        (1.0, ("", "")),
        (180.0 / PI, ("rad", "deg/s")),
        (PI / 180.0, ("deg", "rad/s")),
        (30.0 / PI, ("rad", "rpm")),
        (1.0 / 6.0, ("deg", "rpm")),
    ];
    known.into_iter().find(|(x, _)| (ratio / x - 1.0).abs() < 0.1).map(|(_, units)| units)
}

/// Σ velocity · slope over Σ slope².
fn ratio(t: &[f64], seconds: f64, q: &[Vec<f64>], dq: &[Vec<f64>]) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for (q, dq) in q.iter().zip(dq) {
        let rows = t.len().min(q.len()).min(dq.len());
        for [slope, mean, _] in slopes((&t[..rows], seconds), q, dq) {
            product += mean * slope;
            square += slope * slope;
        }
    }
    Some(product / square).filter(|ratio| ratio.is_finite())
}

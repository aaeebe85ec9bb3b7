//! Signal → spikes, and the signal without them: a Hampel filter that follows the motion.

use crate::error::SignalError;
use crate::noise::{median, white_noise};

/// What counts as a spike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hampel {
    /// Rows on each side that a row is compared with, three or more.
    pub half_window: usize,
    /// Distance from the running median, in robust standard deviations.
    pub threshold: f64,
    /// Rows in a row that a spike may last; a longer excursion is left alone.
    pub longest: usize,
}

impl Default for Hampel {
    /// Seven rows on each side, six deviations, at most three rows long.
    fn default() -> Self {
        Self { half_window: 7, threshold: 6.0, longest: 3 }
    }
}

/// Smallest deviation that counts as one, so that a signal that hardly moves, or moves in steps,
/// is not full of spikes: the white noise of all of `x`, in its unit.
pub fn spike_scale(x: &[f64]) -> f64 {
    white_noise(x, &vec![false; x.len()]).sigma
}

/// Replaces spikes in place and returns their rows.
///
/// A row is off if it lies `threshold` deviations off the line through the medians of the rows on
/// both sides. The deviation is the scaled median distance of the window from that line, at least
/// `scale`. Rows that are off are a spike if they are few and stand off the rows next to them on
/// both sides. A step is no spike, nor is the peak of a sine, whose window is as bent as itself.
///
/// - `t`: \[s\], m
/// - `x`: m values, at any spacing
/// - `scale`: see [`spike_scale`]
///
/// Spikes are replaced by the cubic through the two nearest good rows on each side. Rows within
/// three of an end are not judged.
///
/// Source: R. Pearson et al., EURASIP J. Adv. Signal Process. 2016:87, with a line for the median.
///
/// # Errors
/// [`SignalError::Setting`], or [`SignalError::TooFewRows`] if `t` and `x` differ in length.
pub fn replace_outliers(
    t: &[f64],
    x: &mut [f64],
    scale: f64,
    hampel: Hampel,
) -> Result<Vec<usize>, SignalError> {
    if hampel.half_window < 3 {
        let (value, expected) = (hampel.half_window as f64, "3 rows or more");
        return Err(SignalError::Setting { what: "half window of outliers", value, expected });
    }
    if hampel.threshold.is_nan() || hampel.threshold <= 0.0 {
        let expected = "above 0";
        let value = hampel.threshold;
        return Err(SignalError::Setting { what: "threshold of outliers", value, expected });
    }
    if t.len() != x.len() {
        return Err(SignalError::TooFewRows { rows: t.len().min(x.len()), needed: x.len() });
    }
    let spikes = find(x, scale, hampel);
    let mut is_spike = vec![false; x.len()];
    for &row in &spikes {
        is_spike[row] = true;
    }
    for &row in &spikes {
        let good = |row: &usize| !is_spike[*row];
        let mut near: Vec<usize> = (0..row).rev().filter(good).take(2).collect();
        near.extend((row + 1..x.len()).filter(good).take(2));
        x[row] = lagrange(t, x, &near, t[row]);
    }
    Ok(spikes)
}

/// Rows of all spikes no longer than they may be.
fn find(x: &[f64], scale: f64, hampel: Hampel) -> Vec<usize> {
    let mut space = Vec::with_capacity(2 * hampel.half_window + 1);
    let mut spikes = Vec::new();
    let mut run: Vec<usize> = Vec::new();
    let mut margin = f64::INFINITY;
    for row in 0..x.len() {
        if let Some(distance) = distance(x, row, scale, hampel, &mut space) {
            run.push(row);
            margin = margin.min(0.5 * distance);
        } else {
            if is_spike(x, &run, margin, hampel.longest) {
                spikes.append(&mut run);
            }
            run.clear();
            margin = f64::INFINITY;
        }
    }
    spikes
}

/// Whether the run is short and stands off its neighbours on both sides, to the same side.
fn is_spike(x: &[f64], run: &[usize], margin: f64, longest: usize) -> bool {
    let (Some(&first), Some(&last)) = (run.first(), run.last()) else { return false };
    let neighbours = [x[first - 1], x[last + 1]];
    let inside = || x[first..=last].iter().flat_map(|x| neighbours.map(|y| x - y));
    run.len() <= longest && (inside().all(|d| d > margin) || inside().all(|d| d < -margin))
}

/// How far `row` is off the line through the medians of both sides, if that is too far.
fn distance(
    x: &[f64],
    row: usize,
    scale: f64,
    hampel: Hampel,
    space: &mut Vec<f64>,
) -> Option<f64> {
    let width = hampel.half_window.min(row).min(x.len() - 1 - row);
    if width < 3 {
        return None;
    }
    let mut median_of = |side: &[f64]| {
        space.clear();
        space.extend_from_slice(side);
        median(space)
    };
    let (low, high) = (median_of(&x[row - width..row]), median_of(&x[row + 1..=row + width]));
    let slope = (high - low) / (width + 1) as f64;
    let line = |k: usize| 0.5 * (low + high) + slope * (k as f64 - width as f64);
    space.clear();
    space.extend((0..=2 * width).map(|k| (x[row - width + k] - line(k)).abs()));
    let distance = space[width];
    let deviation = (1.4826 * median(space)).max(scale);
    (distance > hampel.threshold * deviation).then_some(distance)
}

/// The polynomial through the rows `near`, at `at`; the mean time step is no matter.
fn lagrange(t: &[f64], x: &[f64], near: &[usize], at: f64) -> f64 {
    let basis = |i: usize| -> f64 {
        let others = near.iter().filter(|j| **j != i);
        others.map(|&j| (at - t[j]) / (t[i] - t[j])).product()
    };
    near.iter().map(|&i| x[i] * basis(i)).sum()
}

#[cfg(test)]
mod tests;

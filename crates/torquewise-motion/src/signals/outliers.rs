//! Outliers of a signal: a Hampel filter that follows the motion.

use crate::signals::noise::quantisation;
use crate::signals::spline::lagrange;
use crate::{ends, median};
use std::ops::RangeInclusive;

const ROUNDS: usize = 3;

/// Rows on each side that a row is compared with.
pub(crate) const HALF_WINDOW: usize = 7;

/// Distance of a spike from the running median, in robust standard deviations.
const THRESHOLD: f64 = 6.0;

/// Rows in a row that a spike may last; a longer excursion is left alone.
const LONGEST: usize = 3;

/// Smallest deviation that counts as one, so that a signal that hardly moves, or moves in steps,
/// is not full of spikes: the middle one of the third differences of `x`, as a standard deviation,
/// which few spikes do not change; at least the step of its quantisation.
pub(crate) fn spike_scale(x: &[f64]) -> f64 {
    let third = |w: &[f64]| (w[3] - 3.0 * (w[2] - w[1]) - w[0]).abs();
    let mut differences: Vec<f64> = x.windows(4).map(third).collect();
    let step = quantisation(x).map_or_else(|| between_two(x), |quantisation| quantisation.step);
    // Weights 1, 3, 3 and 1 add up to a variance of 20.
    (1.4826 * median(&mut differences) / 20.0_f64.sqrt()).max(step)
}

/// The step of a signal at rest that goes to and fro between two values, each of a hundredth of the rows
/// at least; else 0.
fn between_two(x: &[f64]) -> f64 {
    let [low, high] = ends(x.iter().copied());
    let of = |value: f64| x.iter().filter(|x| x.total_cmp(&value).is_eq()).count();
    let [lows, highs] = [low, high].map(of);
    if lows + highs == x.len() && lows.min(highs) > x.len() / 100 { high - low } else { 0.0 }
}

/// Replaces spikes in place and returns their rows.
///
/// A row is off if it lies six deviations off the line through the medians of the rows on
/// both sides. The deviation is the scaled median distance of the window from that line, at least
/// `scale`. Rows that are off are a spike if they are few and stand off the rows next to them on
/// both sides. A step is no spike, nor is the peak of a sine, whose window is as bent as itself.
///
/// - `t`: \[s\], m
/// - `x`: m values, at any spacing
/// - `scale`: see [`spike_scale`]
///
/// Spikes are replaced by the cubic through the two nearest good rows on each side. Rows within
/// three of an end are judged by the one side they have.
///
/// Source: R. Pearson et al., EURASIP J. Adv. Signal Process. 2016:87, with a line for the median.
pub(crate) fn replace_outliers(t: &[f64], x: &mut [f64], scale: f64) -> Vec<usize> {
    let mut is_spike = vec![false; x.len()];
    // What stands beside a spike is judged once that is gone.
    for _ in 0..ROUNDS {
        let found = find(x, scale);
        if found.is_empty() {
            break;
        }
        for &row in &found {
            is_spike[row] = true;
        }
        let good = |row: &usize| !is_spike[*row];
        for &row in &found {
            let mut near: Vec<usize> = (0..row).rev().filter(good).take(2).collect();
            near.extend((row + 1..x.len()).filter(good).take(2));
            let stamps: Vec<f64> = near.iter().map(|&row| t[row]).collect();
            let weights = lagrange(&stamps, t[row]);
            x[row] = near.iter().zip(weights).map(|(&row, weight)| x[row] * weight).sum();
        }
    }
    (0..x.len()).filter(|row| is_spike[*row]).collect()
}

fn find(x: &[f64], scale: f64) -> Vec<usize> {
    let mut space = Vec::with_capacity(2 * HALF_WINDOW + 1);
    let off = |row| Some((row, distance(x, row, scale, &mut space)?));
    let off: Vec<(usize, f64)> = (0..x.len()).filter_map(off).collect();
    let mut spikes = at_the_ends(x, scale);
    for run in off.chunk_by(|a, b| a.0 + 1 == b.0) {
        let rows = run[0].0..=run[run.len() - 1].0;
        let least = run.iter().map(|(_, distance)| *distance).fold(f64::INFINITY, f64::min);
        if is_spike(x, rows.clone(), 0.5 * least) {
            spikes.extend(rows);
        }
    }
    spikes
}

/// Rows at an end that are not judged by both their sides, and of each of the groups whose medians
/// say where the signal comes from.
const END: usize = 3;
const GROUP: usize = 7;

/// Spikes in the first and last rows: off the line that the medians of the rows next to them lie
/// on, by more than these bend.
fn at_the_ends(x: &[f64], scale: f64) -> Vec<usize> {
    if x.len() < 2 * (END + 3 * GROUP) {
        return Vec::new();
    }
    let last = x.len() - 1;
    let mut found = Vec::new();
    for from_end in [false, true] {
        let at = |k: usize| if from_end { x[last - k] } else { x[k] };
        let group = |g: usize| -> f64 {
            let begin = END + g * GROUP;
            median(&mut (begin..begin + GROUP).map(at).collect::<Vec<f64>>())
        };
        let [near, middle, far] = [0, 1, 2].map(group);
        let slope = (middle - near) / GROUP as f64;
        let line = |k: usize| near + slope * (k as f64 - (END + GROUP / 2) as f64);
        let mut rest: Vec<f64> = (END..END + 2 * GROUP).map(|k| (at(k) - line(k)).abs()).collect();
        let deviation = (1.4826 * median(&mut rest)).max(scale);
        let allowed = THRESHOLD * deviation + 2.0 * (far - 2.0 * middle + near).abs();
        let spikes = (0..END).filter(|&k| (at(k) - line(k)).abs() > allowed);
        found.extend(spikes.map(|k| if from_end { last - k } else { k }));
    }
    found
}

/// Whether the run is short and each of its rows stands off the neighbours on both sides.
fn is_spike(x: &[f64], run: RangeInclusive<usize>, margin: f64) -> bool {
    let (first, last) = run.into_inner();
    let rows = last + 1 - first;
    if rows > LONGEST {
        return false;
    }
    let (before, after) = (x[first - 1], x[last + 1]);
    let slope = (after - before) / (rows + 1) as f64;
    let off = |from: f64, steps: usize, row: usize| (x[row] - from - slope * steps as f64).abs();
    // A signal that moves on between the two is no step unless it goes all the way.
    let is_step = (first..=last).any(|row| {
        (x[row] - before).abs().min((x[row] - after).abs()) < 0.5 * (after - before).abs()
            && (after - before).abs() > margin
    });
    !is_step && (first..=last).all(|row| off(before, row + 1 - first, row) > margin)
}

/// How far `row` is off the line through the medians of both sides, if that is too far.
fn distance(x: &[f64], row: usize, scale: f64, space: &mut Vec<f64>) -> Option<f64> {
    let width = HALF_WINDOW.min(row).min(x.len() - 1 - row);
    if width < 3 {
        return None;
    }
    let mut median_of = |side: &[f64]| {
        space.clear();
        space.extend_from_slice(side);
        median(space)
    };
    let (low, high) = (median_of(&x[row - width..row]), median_of(&x[row + 1..=row + width]));
    let distance = (x[row] - 0.5 * (low + high)).abs();
    // No deviation is smaller than the scale.
    if distance <= THRESHOLD * scale {
        return None;
    }
    let slope = (high - low) / (width + 1) as f64;
    let line = |k: usize| 0.5 * (low + high) + slope * (k as f64 - width as f64);
    space.clear();
    space.extend((0..=2 * width).map(|k| (x[row - width + k] - line(k)).abs()));
    let deviation = (1.4826 * median(space)).max(scale);
    (distance > THRESHOLD * deviation).then_some(distance)
}

#[cfg(test)]
mod tests;

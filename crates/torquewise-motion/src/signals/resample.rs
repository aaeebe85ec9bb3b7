//! Resampling: how even the time stamps are, and signals on an even grid.

use crate::signals::spline::{interpolate, lagrange};
use crate::{MotionError, Repairs, Result, whole};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Jitter below which stamps count as even and are kept as they are.
pub(crate) const EVEN: f64 = 1e-6;

/// An even grid may have this many times the rows of the log, and 1000 more.
const MAX_GROWTH: f64 = 4.0;

/// How evenly a log is stamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// One over the median step, or over the mean of even ones \[Hz\].
    pub rate: f64,
    /// Standard deviation of the steps over the median step.
    pub jitter: f64,
    /// Longest step \[s\].
    pub longest_step: f64,
    /// Row at which the longest step ends.
    pub longest_step_row: usize,
    /// Root mean square deviation of the stamps from the straight line through them, against row
    /// number, in median steps.
    pub line_deviation: f64,
}

impl Timing {
    pub(crate) fn is_even(&self) -> bool {
        self.jitter < EVEN
    }

    /// `line_deviation` over what steps of this jitter give if each stamp errs by itself.
    ///
    /// About 1: the device sampled evenly, and the stamps are those of a jittery receiver. Far
    /// above 1: the steps themselves vary, or rows are lost. `None` for even stamps.
    pub(crate) fn receive_ratio(&self) -> Option<f64> {
        (!self.is_even()).then(|| self.line_deviation / (self.jitter * 0.5_f64.sqrt()))
    }
}

/// How evenly `t` \[s\], which increases, is stamped.
pub(crate) fn timing(t: &[f64]) -> Result<Timing> {
    if t.len() < 4 {
        return Err(MotionError::TooFewRows { rows: t.len(), needed: 4 });
    }
    let steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let median = 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]);
    let mean = (t[t.len() - 1] - t[0]) / steps.len() as f64;
    let variance = steps.iter().map(|step| (step - mean).powi(2)).sum::<f64>() / steps.len() as f64;
    // Of equal ones the first.
    let longest = steps.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1));
    let (before, &longest_step) = longest.unwrap_or((0, &steps[0]));
    let jitter = variance.sqrt() / median;
    Ok(Timing {
        // The mean of even steps has the smaller rounding; that of others counts gaps in.
        rate: if jitter < EVEN { 1.0 / mean } else { 1.0 / median },
        jitter,
        longest_step,
        longest_step_row: before + 1,
        line_deviation: line_deviation(t) / median,
    })
}

/// Root mean square distance of `t` from its line of least squares over row numbers \[s\].
fn line_deviation(t: &[f64]) -> f64 {
    let n = t.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = t.iter().map(|x| x - t[0]).sum::<f64>() / n;
    let rows = || t.iter().enumerate().map(|(k, x)| (k as f64 - middle, x - t[0] - mean));
    let slope = rows().map(|(k, x)| k * x).sum::<f64>() / rows().map(|(k, _)| k * k).sum::<f64>();
    (rows().map(|(k, x)| (x - slope * k).powi(2)).sum::<f64>() / n).sqrt()
}

/// Stamps `origin` + k/`rate` that lie within `t`, and the first k.
pub(crate) fn grid(t: &[f64], origin: f64, timing: &Timing) -> Result<(usize, Vec<f64>)> {
    let Timing { rate, longest_step: gap, longest_step_row: row, .. } = *timing;
    let (Some(begin), Some(end)) = (t.first(), t.last()) else { return Ok((0, Vec::new())) };
    // Rounding must not lose the first or last row.
    let first = ((begin - origin) * rate - 1e-6).ceil().max(0.0);
    let last = ((end - origin) * rate + 1e-6).floor();
    let rows = (last - first + 1.0).max(0.0);
    if rows.is_nan() || rows > MAX_GROWTH * t.len() as f64 + 1000.0 {
        return Err(MotionError::Gap { row, gap, step: 1.0 / rate, rows });
    }
    let (first, rows) = (whole(first), whole(rows));
    Ok((first, (first..first + rows).map(|k| origin + k as f64 / rate).collect()))
}

/// Rows of a local polynomial, of degree one less.
const WIDTH: usize = 8;
/// Steps, in usual ones, between which a local polynomial is safe. Of rows closer together only
/// the first is used: the slope between them would be noise.
const SHORTEST: f64 = 0.25;
const LONGEST: f64 = 2.0;

/// Counts the steps of `t` \[s\] that are bridged where `rate` is usual \[Hz\].
pub(crate) fn count_gaps(t: &[f64], rate: f64, repairs: &mut Repairs) {
    let steps = t.windows(2).map(|pair| pair[1] - pair[0]);
    steps.filter(|step| step * rate > LONGEST).for_each(|step| repairs.add_gap(step));
}

/// Interpolation from uneven stamps to given times, made once for all signals of a log.
///
/// A polynomial of degree 7 through the eight nearest rows, where they are about evenly spaced: a
/// tone at a tenth of the rate is right to 1e-4. Over gaps, the cubic of least squares through as
/// much on both sides. Elsewhere the cubic spline, which keeps to the neighbours. Nothing is
/// delayed.
#[derive(Clone, Debug)]
pub(crate) struct Resampler {
    /// Rows that are used, and their stamps.
    rows: Vec<usize>,
    t: Vec<f64>,
    at: Vec<f64>,
    /// First of the rows and their weights, for each time.
    local: Vec<Option<(usize, Vec<f64>)>>,
}

impl Resampler {
    /// - `t`: \[s\], strictly increasing, m
    /// - `at`: times to interpolate to \[s\], increasing
    /// - `rate`: usual rows per second \[Hz\]
    pub(crate) fn new(t: &[f64], at: &[f64], rate: f64) -> Self {
        let mut rows: Vec<usize> = Vec::with_capacity(t.len());
        for row in 0..t.len() {
            if rows.last().is_none_or(|&last| (t[row] - t[last]) * rate >= SHORTEST) {
                rows.push(row);
            }
        }
        let t: Vec<f64> = rows.iter().map(|&row| t[row]).collect();
        let regular = |begin: usize| {
            let steps = t[begin..begin + WIDTH].windows(2).map(|pair| pair[1] - pair[0]);
            steps.fold(0.0, f64::max) * rate <= LONGEST
        };
        let local = at.iter().map(|&at| {
            let after = t.partition_point(|t| *t <= at);
            if after > 0 && after < t.len() && (t[after] - t[after - 1]) * rate > LONGEST {
                return bridge(&t, after, at, rate);
            }
            let begin = after.checked_sub(WIDTH / 2)?;
            let inside = begin + WIDTH <= t.len() && regular(begin);
            inside.then(|| (begin, lagrange(&t[begin..begin + WIDTH], at)))
        });
        let local = local.collect();
        Self { rows, t, at: at.to_vec(), local }
    }

    /// One signal at the new times.
    ///
    /// - `x`: m values
    pub(crate) fn column(&self, x: &[f64]) -> Result<Vec<f64>> {
        let x: Vec<f64> = self.rows.iter().map(|&row| x[row]).collect();
        let mut values = interpolate(&self.t, &x, &self.at)?;
        for (value, local) in values.iter_mut().zip(&self.local) {
            if let Some((begin, weights)) = local {
                *value = weights.iter().zip(&x[*begin..]).map(|(w, x)| w * x).sum();
            }
        }
        Ok(values)
    }
}

/// Coefficients of the polynomial that bridges a gap.
const BRIDGE: usize = 4;

/// The cubic of least squares through the rows that are no farther from a gap than it is long, at
/// one time within it: a spline would take the noise of two rows for a slope.
///
/// - `after`: the row at which the gap ends
fn bridge(t: &[f64], after: usize, at: f64, rate: f64) -> Option<(usize, Vec<f64>)> {
    let (left, right) = (t[after - 1], t[after]);
    let reach = (right - left).max(WIDTH as f64 / rate);
    let begin = t[..after].partition_point(|t| *t < left - reach);
    let end = after + t[after..].partition_point(|t| *t <= right + reach);
    let powers = |t: f64| {
        let u = (t - at) / (right - left + reach);
        std::array::from_fn::<f64, BRIDGE, _>(|k| (0..k).fold(1.0, |power, _| power * u))
    };
    let mut gram = Mat::<f64>::zeros(BRIDGE, BRIDGE);
    for own in t[begin..end].iter().map(|t| powers(*t)) {
        for i in 0..BRIDGE {
            for j in 0..BRIDGE {
                gram[(i, j)] += own[i] * own[j];
            }
        }
    }
    // At the time itself all powers but the first are zero.
    let unit = Mat::from_fn(BRIDGE, 1, |k, _| f64::from(u8::from(k == 0)));
    let solved = gram.llt(Side::Lower).ok()?.solve(unit);
    let weight = |t: &f64| powers(*t).iter().enumerate().map(|(k, x)| x * solved[(k, 0)]).sum();
    Some((begin, t[begin..end].iter().map(weight).collect()))
}

#[cfg(test)]
mod tests;

//! Columns without spikes, on even time stamps.

use crate::signals::outliers::{HALF_WINDOW, replace_outliers, spike_scale};
use crate::signals::resample::{EVEN, Resampler, Timing, grid, timing};
use crate::{MotionError, Raw, Result, Signal, whole};

/// Jitter up to which stamps may stray in a log that was found even.
const STRAY: f64 = 100.0 * EVEN;

/// Smallest deviations of q, q̇, q̈ and τ that spikes are told by: smaller ones, as quanta of a fine
/// encoder at rest, harm nothing.
const LEAST_SCALES: [f64; 4] = [1e-6, 1e-4, 0.0, 0.0];

/// Rows of one column that were replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outliers {
    /// q, dq, ddq or tau.
    pub signal: &'static str,
    /// Name of the joint.
    pub joint: String,
    /// Rows of the raw log, ascending.
    pub rows: Vec<usize>,
}

/// What all parts of a log are cleaned by.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Base {
    pub(crate) timing: Timing,
    /// Of each signal and joint, empty where there is no such signal or nothing to be looked for.
    pub(crate) scales: [Vec<f64>; 4],
}

impl Base {
    pub(crate) fn of(columns: &Raw) -> Result<Self> {
        let timing = timing(&columns.t)?;
        let scales = Signal::ALL.map(|signal| {
            let least = LEAST_SCALES[signal as usize];
            columns.of(signal).iter().map(|column| spike_scale(column).max(least)).collect()
        });
        Ok(Self { timing, scales })
    }

    /// Rows to each side on which a cleaned row depends, to rounding.
    pub(crate) fn reach(&self) -> usize {
        // The influence of a row on a spline falls by 0.27 a row: 1e-17 after 30 even ones.
        // A bridge reaches as far as its gap is long, a hundred thousand rows at most.
        let gap = whole((self.timing.longest_step * self.timing.rate).ceil().clamp(0.0, 1e5));
        let spline = if self.timing.is_even() { 0 } else { 80 + gap };
        spline + HALF_WINDOW + 8
    }
}

/// Signals on even stamps, row 0 at grid index `first`.
#[derive(Clone, Debug)]
pub(crate) struct Even {
    pub(crate) first: usize,
    pub(crate) columns: Raw,
    pub(crate) outliers: Vec<Outliers>,
}

/// A whole trajectory checked and cleaned, and by what.
pub(crate) fn cleaned(columns: &Raw) -> Result<(Base, Even)> {
    columns.check()?;
    let base = Base::of(columns)?;
    let even = clean(columns, &base, (columns.t[0], 0))?;
    Ok((base, even))
}

/// Takes out spikes and resamples if the log is uneven.
///
/// - `origin`: time \[s\] and raw row of the first row of `columns`: the first stamp of the
///   trajectory, and how many rows came before
pub(crate) fn clean(columns: &Raw, base: &Base, origin: (f64, usize)) -> Result<Even> {
    let mut outliers = Vec::new();
    let despiked = columns.map(columns.t.clone(), |signal, joint, column| {
        let mut column = column.to_vec();
        if let Some(&scale) = base.scales[signal as usize].get(joint) {
            let mut rows = replace_outliers(&columns.t, &mut column, scale);
            if !rows.is_empty() {
                for row in &mut rows {
                    *row += origin.1;
                }
                let joint = columns.joints[joint].clone();
                outliers.push(Outliers { signal: signal.name(), joint, rows });
            }
        }
        Ok(column)
    })?;
    let now = timing(&columns.t)?;
    if base.timing.is_even() {
        let off = (now.rate / base.timing.rate - 1.0).abs();
        if now.jitter > STRAY || off > STRAY {
            return Err(MotionError::Uneven { row: origin.1 + now.longest_step_row });
        }
        return Ok(Even { first: origin.1, columns: despiked, outliers });
    }
    let even = Timing { rate: base.timing.rate, ..now };
    let (first, at) = grid(&columns.t, origin.0, &even)?;
    let resampler = Resampler::new(&columns.t, &at, base.timing.rate);
    let columns = despiked.map(at, |_, _, column| resampler.column(column))?;
    Ok(Even { first, columns, outliers })
}

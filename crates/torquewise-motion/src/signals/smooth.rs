//! Filtered q, q̇, q̈, τ, and the rows of them that are kept.

use crate::signals::butterworth::{filtfilt, low_pass};
use crate::signals::delay::shift;
use crate::signals::derivative::even_derivative;
use crate::signals::raw::{Raw, Signal, matrix};
use crate::{Motion, Result, Signals};
use std::ops::Range;

pub(crate) fn filter(columns: &Raw, cutoff: f64, rate: f64) -> Result<Raw> {
    let sections = low_pass(cutoff, rate)?;
    columns.map(columns.t.clone(), |_, _, column| {
        let mut column = column.to_vec();
        filtfilt(&sections, &mut column)?;
        Ok(column)
    })
}

/// Derivatives of the filtered signals, and the torque advanced by its delay.
pub(crate) fn smooth(filtered: &Raw, even: &Raw, rate: f64, delay: f64) -> Result<Motion> {
    let q = matrix(filtered.of(Signal::Q));
    let [dq, ddq] = [1, 2].map(|order| even_derivative(q.as_ref(), rate, order));
    let (dq, ddq) = (dq?, ddq?);
    let advanced = |tau: &Vec<Vec<f64>>| {
        matrix(&tau.iter().map(|x| shift(x, rate, delay)).collect::<Vec<_>>())
    };
    let [tau, raw] = [filtered, even]
        .map(|columns| columns.signals[Signal::Tau as usize].as_ref().map(advanced));
    let removed_tau = tau.as_ref().zip(raw).map(|(tau, raw)| raw - tau);
    let (joints, t) = (filtered.joints.clone(), filtered.t.clone());
    Ok(Motion::new(Signals { joints, t, q, dq, ddq, tau })?.with_removed_tau(removed_tau))
}

/// The rows of these grid indices that are not left out; `None` if there is none.
///
/// - `first`: grid index of row 0
pub(crate) fn kept(
    motion: &Motion,
    first: usize,
    indices: Range<usize>,
    keep_every: usize,
) -> Option<Motion> {
    let end = indices.end.min(first + motion.n_rows());
    let begin = indices.start.max(first).next_multiple_of(keep_every);
    let rows: Vec<usize> = (begin..end).step_by(keep_every).map(|index| index - first).collect();
    (!rows.is_empty()).then(|| motion.select(&rows))
}

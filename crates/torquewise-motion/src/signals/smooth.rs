//! Filtered q, q̇, q̈, τ, and the rows of them that are kept.

use crate::error::Result;
use crate::signals::butterworth::{filtfilt, low_pass};
use crate::signals::clean::Even;
use crate::signals::delay::shift;
use crate::signals::derivative::even_derivative;
use crate::signals::plan::SignalPlan;
use crate::signals::raw::{Raw, Signal, matrix};
use crate::{Motion, Signals};
use std::ops::Range;

/// Filtered and derived signals on the even grid, row 0 at grid index `first`.
pub(crate) struct Smooth {
    first: usize,
    pub(crate) motion: Motion,
}

pub(crate) fn filter(even: &Even, plan: &SignalPlan) -> Result<Raw> {
    let columns = &even.columns;
    let Some(cutoff) = plan.cutoff else { return Ok(columns.clone()) };
    let sections = low_pass(cutoff, plan.rate)?;
    columns.map(columns.t.clone(), |_, _, column| {
        let mut column = column.to_vec();
        filtfilt(&sections, &mut column)?;
        Ok(column)
    })
}

/// Derivatives of the filtered signals, and the torque advanced by its delay.
pub(crate) fn smooth(filtered: &Raw, even: &Even, plan: &SignalPlan) -> Result<Smooth> {
    let q = matrix(filtered.of(Signal::Q));
    let [dq, ddq] = [1, 2].map(|order| even_derivative(q.as_ref(), plan.rate, order));
    let (dq, ddq) = (dq?, ddq?);
    let delay = plan.settings.delay;
    let advanced = |tau: &Vec<Vec<f64>>| {
        matrix(&tau.iter().map(|x| shift(x, plan.rate, delay)).collect::<Vec<_>>())
    };
    let [tau, raw] = [filtered, &even.columns]
        .map(|columns| columns.signals[Signal::Tau as usize].as_ref().map(advanced));
    let removed_tau = tau.as_ref().zip(raw).map(|(tau, raw)| raw - tau);
    let (joints, t) = (filtered.joints.clone(), filtered.t.clone());
    let motion = Motion::new(Signals { joints, t, q, dq, ddq, tau })?;
    Ok(Smooth { first: even.first, motion: motion.with_removed_tau(removed_tau) })
}

impl Smooth {
    /// The rows of these grid indices that are not left out; `None` if there is none.
    pub(crate) fn rows(&self, indices: Range<usize>, keep_every: usize) -> Option<Motion> {
        let end = indices.end.min(self.first + self.motion.n_rows());
        let begin = indices.start.max(self.first).next_multiple_of(keep_every);
        let rows: Vec<usize> =
            (begin..end).step_by(keep_every).map(|index| index - self.first).collect();
        (!rows.is_empty()).then(|| self.motion.select(&rows))
    }
}

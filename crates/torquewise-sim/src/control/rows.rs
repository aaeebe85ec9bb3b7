//! From desired motion to rows: q, q̇ and q̈ at each tick of the controller.

use crate::control::error::ControlError;
use faer::MatRef;
use torquewise_motion::Motion;

/// What is wanted of the joints at one tick, n each.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    pub(crate) q: Vec<f64>,
    pub(crate) dq: Vec<f64>,
    pub(crate) ddq: Vec<f64>,
}

impl Target {
    /// A row of the desired motion.
    pub(crate) fn of(motion: &Motion, row: usize) -> Self {
        let of = |x: MatRef<'_, f64>| x.row(row).iter().copied().collect();
        Self { q: of(motion.q()), dq: of(motion.dq()), ddq: of(motion.ddq()) }
    }
}

/// Time between rows may differ by this share of itself: stamps are rounded.
const SLACK: f64 = 1e-3;

/// Seconds between the rows of a desired motion.
pub(crate) fn period(motion: &Motion) -> Result<f64, ControlError> {
    let (t, rows) = (motion.t(), motion.n_rows());
    let [first, .., last] = t else { return Err(ControlError::TooShort { rows }) };
    let period = (last - first) / (rows - 1) as f64;
    let uneven = |pair: &[f64]| {
        let step = pair.iter().copied().reduce(|before, after| after - before);
        step.is_none_or(|step| (step - period).abs() > SLACK * period.abs())
    };
    match t.windows(2).position(uneven) {
        Some(row) => Err(ControlError::Uneven { row: row + 1 }),
        None if period > 0.0 => Ok(period),
        None => Err(ControlError::Uneven { row: 1 }),
    }
}

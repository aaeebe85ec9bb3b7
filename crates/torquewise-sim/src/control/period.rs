//! The control period of a desired motion.

use crate::error::SimError;
use torquewise_motion::Motion;

/// Time between rows may differ by this share of itself: stamps are rounded.
const SLACK: f64 = 1e-3;

/// Seconds between the rows of a desired motion.
pub(crate) fn period(motion: &Motion) -> Result<f64, SimError> {
    let (t, rows) = (motion.t(), motion.n_rows());
    let [first, .., last] = t else { return Err(SimError::TooFewRows { rows }) };
    let period = (last - first) / (rows - 1) as f64;
    let uneven = |pair: &[f64]| {
        let step = pair.iter().copied().reduce(|before, after| after - before);
        step.is_none_or(|step| (step - period).abs() > SLACK * period.abs())
    };
    match t.windows(2).position(uneven) {
        Some(row) => Err(SimError::Uneven { row: row + 1 }),
        None if period > 0.0 => Ok(period),
        None => Err(SimError::Uneven { row: 1 }),
    }
}

//! Positions, velocities and accelerations of n joints at one instant.

use faer::MatRef;
use torquewise_motion::Motion;

/// Where the joints are and how they move at one instant, n each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Positions \[rad\].
    pub q: Vec<f64>,
    /// Velocities \[rad/s\].
    pub dq: Vec<f64>,
    /// Accelerations \[rad/s²\].
    pub ddq: Vec<f64>,
}

impl State {
    /// At rest.
    pub fn at_rest(q: &[f64]) -> Self {
        Self { q: q.to_vec(), dq: vec![0.0; q.len()], ddq: vec![0.0; q.len()] }
    }

    /// A row of a motion.
    pub(crate) fn of(motion: &Motion, row: usize) -> Self {
        let of = |x: MatRef<'_, f64>| x.row(row).iter().copied().collect();
        Self { q: of(motion.q()), dq: of(motion.dq()), ddq: of(motion.ddq()) }
    }
}

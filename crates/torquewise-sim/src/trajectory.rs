//! Simulated motions: exact q, q̇, q̈ at any row, without torque.

mod moves;
mod sines;
mod staged;

use crate::{Arm, MotionKind, MotionPlan, Result, State};
use moves::Moves;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sines::Sines;
use staged::Staged;

/// Speed \[rad/s\] of the fastest joint at most.
const PEAK_SPEED: f64 = 1.5;
/// Least and greatest acceleration \[rad/s²\] of the fastest joint.
const ACCELERATION: [f64; 2] = [2.0, 6.0];

/// A drawn motion: every random choice is made, every row can be asked for.
#[derive(Clone, Debug)]
pub(crate) enum Trajectory {
    Moves(Moves),
    Sines(Sines),
    Staged(Staged),
}

impl Trajectory {
    pub(crate) fn draw(arm: &Arm, plan: &MotionPlan) -> Result<Self> {
        let (n_rows, ranges) = (plan.n_rows()?, arm.ranges());
        let mut rng = ChaCha8Rng::seed_from_u64(plan.seed);
        Ok(match plan.kind {
            MotionKind::Moves => Self::Moves(Moves::draw(&ranges, plan.seconds, &mut rng)),
            MotionKind::Sines => Self::Sines(Sines::draw(&ranges, &mut rng)),
            MotionKind::Staged => Self::Staged(Staged::draw(&ranges, n_rows, plan.rate, &mut rng)),
        })
    }

    /// Time \[s\] and state of a row, of so many per second.
    pub(crate) fn state_at(&self, row: usize, rate: f64) -> (f64, State) {
        let t = row as f64 / rate;
        match self {
            Self::Moves(moves) => (t, moves.state_at(t)),
            Self::Sines(sines) => (t, sines.state_at(t)),
            Self::Staged(staged) => staged.state_at(row),
        }
    }
}

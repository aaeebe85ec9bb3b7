//! What a simulated log should hold.

use crate::{Result, check_between};
use torquewise_motion::whole;

/// How the joints are moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MotionKind {
    /// Positioning and sorting: dwell, accelerate, cruise, brake, dwell, all joints together.
    #[default]
    Moves,
    /// Smooth sums of sines, for judging a model outside its training set.
    Sines,
    /// Three recordings in one log: poses held, constant speeds, constant accelerations. The
    /// transfers between them are not recorded and leave gaps in time.
    Staged,
}

/// What [`simulate`](crate::simulate()) should produce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionPlan {
    /// How the joints are moved.
    pub kind: MotionKind,
    /// Recorded time \[s\], at most 1 000 000.
    pub seconds: f64,
    /// Rows per second \[Hz\], at most 100 000.
    pub rate: f64,
    /// Seed of every random choice: one seed, one log, bit by bit.
    pub seed: u64,
}

impl Default for MotionPlan {
    /// 40 000 rows of positioning and sorting, as in the paper's simulation.
    fn default() -> Self {
        Self { kind: MotionKind::Moves, seconds: 160.0, rate: 250.0, seed: 0 }
    }
}

/// Rows of one simulated log at most.
const MAX_ROWS: f64 = 50_000_000.0;

impl MotionPlan {
    /// Number of rows, once the numbers of the plan are found fine.
    ///
    /// # Errors
    /// `SimError::Setting`, naming the number at fault.
    pub fn n_rows(&self) -> Result<usize> {
        let up_to = |most| [f64::MIN_POSITIVE, most];
        let expected = "more than 0 and at most 1000000";
        check_between("length [s]", self.seconds, up_to(1e6), expected)?;
        let expected = "more than 0 and at most 100000";
        check_between("rate [Hz]", self.rate, up_to(1e5), expected)?;
        let rows = (self.seconds * self.rate).round();
        let expected = "seconds times rate from 1 to 50000000";
        check_between("number of rows", rows, up_to(MAX_ROWS), expected)?;
        Ok(whole(rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SimError;

    #[test]
    fn the_default_plan_has_forty_thousand_rows_and_one_without_end_or_beginning_is_refused() {
        let default = MotionPlan::default();
        assert_eq!(default.n_rows().unwrap(), 40_000);
        let plans = [
            MotionPlan { seconds: f64::INFINITY, ..default },
            MotionPlan { seconds: -1.0, ..default },
            MotionPlan { rate: f64::NAN, ..default },
            MotionPlan { rate: 0.0, ..default },
            MotionPlan { seconds: 1e6, rate: 1e5, ..default },
            MotionPlan { seconds: 1.0, rate: 0.1, ..default },
        ];

        for plan in plans {
            assert!(matches!(plan.n_rows(), Err(SimError::Setting { .. })), "{plan:?}");
        }
    }
}

//! From arm, seconds, noise, seed to the log that is learned from and the motion that judges.

use crate::error::PaperError;
use serde::Serialize;
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, Simulation, add_noise, simulate};

/// Rows per second of every log \[Hz\].
pub(crate) const RATE: f64 = 100.0;
/// Length of the motion that models are judged by \[s\].
pub(crate) const TEST_SECONDS: f64 = 20.0;
/// Added to the seed of the results, so that no training log shares the seed of the test.
const TEST_SEED: u64 = 1_000;

/// Signal-to-noise ratio of q, q̇ and q̈ \[dB\]; no number stands for no noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Decibels(pub [Option<f64>; 3]);

impl Decibels {
    /// Case 1 of the paper: no noise.
    pub const NONE: Self = Self([None; 3]);
    /// The noise of the clustering figures: 60 dB on q̇ and 50 dB on q̈.
    pub const CLUSTERING: Self = Self([None, Some(60.0), Some(50.0)]);

    /// The same ratio for each signal given.
    pub fn new(q: f64, dq: f64, ddq: f64) -> Self {
        Self([Some(q), Some(dq), Some(ddq)])
    }

    /// Cases 1, 2 and 3 of the paper.
    pub fn case(case: u8) -> Self {
        match case {
            1 => Self::NONE,
            2 => Self::new(70.0, 50.0, 30.0),
            _ => Self::new(60.0, 40.0, 30.0),
        }
    }

    /// As one reads it: `60/40/30 dB`, `none`.
    pub fn name(&self) -> String {
        if *self == Self::NONE {
            return "none".into();
        }
        let level = |db: &Option<f64>| db.map_or_else(|| "–".into(), |db| db.to_string());
        format!("{} dB", self.0.iter().map(level).collect::<Vec<String>>().join("/"))
    }

    fn noise(&self) -> Result<Noise, PaperError> {
        let [q, dq, ddq] = self.0.map(|db| db.unwrap_or(f64::INFINITY));
        Ok(Noise::from_db(q, dq, ddq)?)
    }
}

/// A log to learn from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Scenario {
    /// Name of a reference arm.
    pub arm: &'static str,
    /// Recorded time \[s\].
    #[serde(rename = "log_length")]
    pub seconds: f64,
    /// Noise in q, q̇ and q̈.
    pub noise: Decibels,
    /// Seed of motion and noise.
    pub seed: u64,
}

impl Scenario {
    /// Positioning and sorting moves without noise, and the pattern that each row truly shows.
    pub(crate) fn simulate(&self) -> Result<Simulation, PaperError> {
        let arm = Arm::builtin(self.arm)?;
        let kind = MotionKind::Moves;
        let plan = MotionPlan { kind, seconds: self.seconds, rate: RATE, seed: self.seed };
        Ok(simulate(&arm, &plan)?)
    }

    /// What the sensors of such an arm record.
    pub(crate) fn record(&self, simulation: &Simulation) -> Result<Motion, PaperError> {
        Ok(add_noise(&simulation.motion, &self.noise.noise()?, self.seed)?)
    }
}

/// Twenty seconds of smooth sines without noise: the motion outside the training log.
pub(crate) fn outside(arm: &str, seed: u64) -> Result<Motion, PaperError> {
    let kind = MotionKind::Sines;
    let seed = seed.wrapping_add(TEST_SEED);
    let plan = MotionPlan { kind, seconds: TEST_SECONDS, rate: RATE, seed };
    Ok(simulate(&Arm::builtin(arm)?, &plan)?.motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_read_as_the_paper_writes_them() {
        assert_eq!(Decibels::case(1).name(), "none");
        assert_eq!(Decibels::case(3).name(), "60/40/30 dB");
        assert_eq!(Decibels::CLUSTERING.name(), "–/60/50 dB");
    }
}

//! How much is done, and the logs that are learned from and judged by.

use crate::PaperError;
use serde::Serialize;
use torquewise_motion::Motion;
use torquewise_sim::{Arm, MotionKind, MotionPlan, Noise, Simulation, add_noise, simulate};

/// Rows per second of every log \[Hz\].
const RATE: f64 = 100.0;
/// Length of the motion that models are judged by \[s\].
const TEST_SECONDS: f64 = 20.0;
/// Added to the seed of the results, so that no training log shares the seed of the test.
const TEST_SEED: u64 = 1_000;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scenario {
    /// Name of a reference arm.
    pub arm: &'static str,
    /// Recorded time \[s\].
    pub seconds: f64,
    /// Noise in q, q̇ and q̈.
    pub noise: Noise,
    /// Seed of motion and noise.
    pub seed: u64,
}

impl Scenario {
    /// Positioning and sorting moves without noise, and the pattern that each row truly shows.
    pub(crate) fn simulate(&self) -> Result<Simulation, PaperError> {
        moved(self.arm, MotionKind::Moves, self.seconds, self.seed)
    }

    /// What the sensors of such an arm record.
    pub(crate) fn record(&self, simulation: &Simulation) -> Result<Motion, PaperError> {
        Ok(add_noise(&simulation.motion, &self.noise, self.seed)?)
    }
}

/// Twenty seconds of smooth sines without noise: the motion outside the training log.
pub(crate) fn outside(arm: &str, seed: u64) -> Result<Motion, PaperError> {
    Ok(moved(arm, MotionKind::Sines, TEST_SECONDS, seed.wrapping_add(TEST_SEED))?.motion)
}

fn moved(arm: &str, kind: MotionKind, seconds: f64, seed: u64) -> Result<Simulation, PaperError> {
    let plan = MotionPlan { kind, seconds, rate: RATE, seed };
    Ok(simulate(&Arm::builtin(arm)?, &plan)?)
}

/// How much is done.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// The arm of most experiments.
    pub arm: &'static str,
    /// First of the consecutive seeds.
    pub seed: u64,
    /// Length of the training logs \[s\].
    #[serde(rename = "log_length")]
    pub seconds: f64,
    /// Seeds, one at least, each another motion and other noise.
    pub seeds: u64,
    /// Seeds, one at least, whose runs are timed, with nothing else at work.
    pub timed_seeds: u64,
    /// Seeds, one at least, at each point of a sweep and each row of the ablation.
    pub sweep_seeds: u64,
    /// Noise of the noise sweep.
    pub noise_levels: Vec<Noise>,
    /// Lengths of the log in the sweep over data \[s\].
    pub lengths: Vec<f64>,
    /// Arms with the length of their log \[s\].
    pub arms: Vec<(&'static str, f64)>,
    /// Length at most of the slow, uniform and variable recording of the arm with friction \[s\].
    pub recordings: [f64; 3],
    /// Largest N₁ tried for the steps.
    pub trig_order: u8,
    /// Largest N₁ tried for the whole library.
    pub whole_order: u8,
}

impl Settings {
    /// All of the paper's arm: a few minutes on two cores.
    pub fn full(seed: u64) -> Self {
        let level = |less: f64| Noise::from_db(70.0 - less, 50.0 - less, 30.0 - less / 1.5).ok();
        Self {
            arm: "puma560-3",
            seed,
            seconds: 600.0,
            seeds: 10,
            timed_seeds: 3,
            sweep_seeds: 2,
            noise_levels: [0.0, 7.5, 15.0, 22.5, 30.0].into_iter().filter_map(level).collect(),
            lengths: vec![30.0, 60.0, 120.0, 300.0, 600.0],
            arms: vec![
                ("planar-2", 600.0),
                ("puma560-3", 600.0),
                ("generic-4", 600.0),
                ("generic-5", 200.0),
            ],
            recordings: [120.0, 120.0, 60.0],
            trig_order: 5,
            whole_order: 4,
        }
    }

    /// Every experiment in small, with an arm of two joints: seconds. The numbers are not the
    /// paper's.
    pub fn quick(seed: u64) -> Self {
        let full = Self::full(seed);
        Self {
            arm: "planar-2",
            seconds: 30.0,
            seeds: 2,
            timed_seeds: 1,
            sweep_seeds: 1,
            noise_levels: vec![full.noise_levels[0], full.noise_levels[4]],
            lengths: vec![15.0, 30.0],
            arms: vec![("planar-2", 30.0), ("puma560-3", 30.0)],
            recordings: [20.0; 3],
            trig_order: 3,
            whole_order: 2,
            ..full
        }
    }

    /// A log of the arm and the length of most experiments.
    pub(crate) fn scenario(&self, noise: Noise) -> Scenario {
        Scenario { arm: self.arm, seconds: self.seconds, noise, seed: self.seed }
    }
}

//! From how much is done to settings: which arm, how many seeds, how long the logs.

use crate::scenario::{Decibels, Scenario};
use serde::Serialize;

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
    pub noise_levels: Vec<Decibels>,
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
        Self {
            arm: "puma560-3",
            seed,
            seconds: 600.0,
            seeds: 10,
            timed_seeds: 3,
            sweep_seeds: 2,
            noise_levels: vec![
                Decibels::new(70.0, 50.0, 30.0),
                Decibels::new(62.5, 42.5, 25.0),
                Decibels::new(55.0, 35.0, 20.0),
                Decibels::new(47.5, 27.5, 15.0),
                Decibels::new(40.0, 20.0, 10.0),
            ],
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
        Self {
            arm: "planar-2",
            seconds: 30.0,
            seeds: 2,
            timed_seeds: 1,
            sweep_seeds: 1,
            noise_levels: vec![Decibels::new(70.0, 50.0, 30.0), Decibels::new(40.0, 20.0, 10.0)],
            lengths: vec![15.0, 30.0],
            arms: vec![("planar-2", 30.0), ("puma560-3", 30.0)],
            recordings: [20.0, 20.0, 20.0],
            trig_order: 3,
            whole_order: 2,
            ..Self::full(seed)
        }
    }

    /// A log of the arm and the length of most experiments.
    pub(crate) fn scenario(&self, noise: Decibels, seed: u64) -> Scenario {
        Scenario { arm: self.arm, seconds: self.seconds, noise, seed }
    }
}

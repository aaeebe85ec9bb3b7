//! Model → is it physics? Random states, a verdict on each property, and words for it.

use crate::table::number;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::f64::consts::PI;
use torquewise::model::{Checks, Model, ModelError, check};

/// States looked at, and the seed they are drawn with.
const STATES: usize = 200;
const SEED: u64 = 0;

/// What was measured, and which properties hold.
pub(crate) struct Physics {
    checks: Checks,
    positive_definite: bool,
    symmetric: bool,
    skew: bool,
}

impl Physics {
    /// Checks a model at random states of its training range.
    pub(crate) fn of(model: &Model) -> Result<Self, ModelError> {
        let checks = check(model, &random_states(model))?;
        // Each property alone passes if it passes beside perfect others.
        let perfect =
            Checks { states: 0, smallest_eigenvalue: 1.0, asymmetry: 0.0, skew_defect: 0.0 };
        let Checks { smallest_eigenvalue, asymmetry, skew_defect, .. } = checks;
        Ok(Self {
            positive_definite: Checks { smallest_eigenvalue, ..perfect.clone() }.passed(),
            symmetric: Checks { asymmetry, ..perfect.clone() }.passed(),
            skew: Checks { skew_defect, ..perfect }.passed(),
            checks,
        })
    }

    /// What was measured.
    pub(crate) fn checks(&self) -> &Checks {
        &self.checks
    }

    /// What does not hold, if anything.
    pub(crate) fn warning(&self) -> Option<String> {
        let mut failures = Vec::new();
        if !self.positive_definite {
            let value = number(self.checks.smallest_eigenvalue);
            failures.push(format!("M(q) has the eigenvalue {value} kg·m²"));
        }
        if !self.symmetric {
            failures.push(format!("M(q) is not symmetric by {:.1e}", self.checks.asymmetry));
        }
        if !self.skew {
            failures.push(format!("dM/dt − 2C is not skew by {:.1e}", self.checks.skew_defect));
        }
        (!failures.is_empty()).then(|| {
            format!(
                "the model is not the physics of a rigid arm: {}; fit --library energy for a \
                 symmetric M(q), and record more motion if that is not positive",
                failures.join(", ")
            )
        })
    }

    /// One line per property.
    pub(crate) fn text(&self) -> String {
        let Checks { states, smallest_eigenvalue, asymmetry, skew_defect } = &self.checks;
        let verdict = |good: bool| if good { "yes" } else { "NO" };
        format!(
            "\nChecked at {states} random states of the training range:\n\
             \x20 M(q) positive definite  {:3}  smallest eigenvalue {} kg·m²\n\
             \x20 M(q) symmetric          {:3}  largest relative asymmetry {asymmetry:.1e}\n\
             \x20 dM/dt − 2C skew         {:3}  largest relative defect {skew_defect:.1e}\n",
            verdict(self.positive_definite),
            number(*smallest_eigenvalue),
            verdict(self.symmetric),
            verdict(self.skew),
        )
    }

    /// The same for programs.
    pub(crate) fn json(&self) -> Value {
        json!({
            "states": self.checks.states,
            "passed": self.checks.passed(),
            "positive_definite": self.positive_definite,
            "symmetric": self.symmetric,
            "skew": self.skew,
            "smallest_eigenvalue": self.checks.smallest_eigenvalue,
            "asymmetry": self.checks.asymmetry,
            "skew_defect": self.checks.skew_defect,
        })
    }
}

/// (q, dq), evenly drawn from what the model was fitted on; a turn and 1 rad/s where not known.
fn random_states(model: &Model) -> Vec<(Vec<f64>, Vec<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let training = &model.training;
    let ranges: Vec<([f64; 2], f64)> = (0..model.n_joints())
        .map(|joint| {
            let range = training.q_range.get(joint).copied().unwrap_or([-PI, PI]);
            (range, training.dq_peak.get(joint).copied().unwrap_or(1.0))
        })
        .collect();
    (0..STATES)
        .map(|_| {
            let state =
                |&([low, high], peak): &([f64; 2], f64)| (between(low, high), between(-peak, peak));
            ranges.iter().map(state).unzip()
        })
        .collect()
}

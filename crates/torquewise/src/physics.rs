//! Whether a model is the physics of an arm: random states, and a verdict on each property.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Serialize, Serializer};
use serde_json::json;
use std::f64::consts::PI;
use std::fmt;
use torquewise_model::checks::weakest_state;
use torquewise_model::number;
use torquewise_model::{Checks, Model, ModelError, check};

/// States looked at in each range unless another number is asked for.
pub const STATES: usize = 10_000;
const SEED: u64 = 0;

/// What was measured, and which properties hold.
#[derive(Clone, Debug)]
pub struct PhysicsCheck {
    /// What was measured in the training range.
    pub trained: Checks,
    whole: Checks,
}

/// Where M(q) is weakest within the training range of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MassMatrix {
    /// Whether M(q) is positive definite there.
    pub positive_definite: bool,
    /// Smallest eigenvalue \[kg·m²\].
    pub smallest_eigenvalue: f64,
    /// Joint angles of that \[rad\], n.
    pub q: Vec<f64>,
}

impl MassMatrix {
    /// Looks at M(q) of a model at random states of its training range.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if the parts of the model do not fit each other.
    pub fn of(model: &Model) -> Result<Self, ModelError> {
        let states = random_states(model, &model.training.q_range, STATES);
        let (smallest_eigenvalue, q) = weakest_state(model, states.iter().map(|(q, _)| q))?;
        Ok(Self { positive_definite: smallest_eigenvalue > 0.0, smallest_eigenvalue, q })
    }

    /// What is wrong with it, if anything: `M(q) has the eigenvalue … at q = (…) rad`.
    pub fn flaw(&self) -> Option<String> {
        (!self.positive_definite).then(|| eigenvalue_at(self.smallest_eigenvalue, &self.q))
    }
}

impl PhysicsCheck {
    /// Checks a model at so many random states of its training range, and as many of a whole turn
    /// of each joint.
    ///
    /// # Errors
    /// As [`MassMatrix::of`].
    pub fn of(model: &Model, states: usize) -> Result<Self, ModelError> {
        let at = |q_range: &[[f64; 2]]| check(model, &random_states(model, q_range, states));
        Ok(Self { trained: at(&model.training.q_range)?, whole: at(&[])? })
    }

    /// The worst of both ranges, of M(q) − M(q)ᵀ and of dM/dt − 2C.
    fn defects(&self) -> [f64; 2] {
        let Self { trained, whole, .. } = self;
        [trained.asymmetry.max(whole.asymmetry), trained.skew_defect.max(whole.skew_defect)]
    }

    /// What does not hold, if anything.
    pub fn warning(&self) -> Option<String> {
        let mut failures = Vec::new();
        let ranges = [(&self.trained, "in the training range"), (&self.whole, "in a whole turn")];
        let weak = ranges.iter().find(|(checks, _)| checks.smallest_eigenvalue <= 0.0);
        if let Some((Checks { smallest_eigenvalue, weakest_q, .. }, range)) = weak {
            failures.push(format!("{} {range}", eigenvalue_at(*smallest_eigenvalue, weakest_q)));
        }
        let [asymmetry, skew] = self.defects();
        for (what, defect) in
            [("M(q) is not symmetric", asymmetry), ("dM/dt − 2C is not skew", skew)]
        {
            if !is_none(defect) {
                failures.push(format!("{what} by {defect:.1e}"));
            }
        }
        let no_arm = (!failures.is_empty()).then(|| {
            format!(
                "no rigid arm moves as this model does: {}; fit the energy library for a symmetric \
                 M(q), and record more motion if that is not positive",
                failures.join(", ")
            )
        });
        let cure =
            "where a real one takes power: fit with linear friction, or record slower motion";
        let driving = self.trained.driving.iter().map(|driving| format!("{driving}, {cure}"));
        no_arm.into_iter().chain(driving).reduce(|all, one| format!("{all}; {one}"))
    }
}

impl fmt::Display for PhysicsCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = |good: bool| if good { "yes" } else { "NO" };
        let states = self.trained.states;
        writeln!(
            f,
            "Checked at {states} random states of the training range and {states} with each joint \
             anywhere from −π to π:"
        )?;
        for (range, checks) in [("training range", &self.trained), ("whole turn", &self.whole)] {
            writeln!(
                f,
                "  M(q) positive definite  {:3}  {range}: smallest eigenvalue {} kg·m² at q = {} \
                 rad",
                verdict(checks.smallest_eigenvalue > 0.0),
                number(checks.smallest_eigenvalue),
                angles(&checks.weakest_q)
            )?;
        }
        let [asymmetry, skew] = self.defects();
        let driving = self.trained.driving.as_ref();
        let friction = driving.map_or_else(
            || "at every speed up to the trained peak, constant offset left aside".to_owned(),
            ToString::to_string,
        );
        writeln!(
            f,
            "  M(q) symmetric          {:3}  largest relative asymmetry {:.1e}\n\
             \x20 dM/dt − 2C skew         {:3}  largest relative defect {:.1e}\n\
             \x20 friction takes power    {:3}  {friction}",
            verdict(is_none(asymmetry)),
            asymmetry,
            verdict(is_none(skew)),
            skew,
            verdict(driving.is_none()),
        )
    }
}

impl Serialize for PhysicsCheck {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { trained, whole } = self;
        let range = |checks: &Checks| {
            json!({
                "states": checks.states,
                "smallest_eigenvalue": checks.smallest_eigenvalue,
                "q": checks.weakest_q,
            })
        };
        let [asymmetry, skew_defect] = self.defects();
        let smallest_eigenvalue = trained.smallest_eigenvalue.min(whole.smallest_eigenvalue);
        let found = json!({
            "states": trained.states + whole.states,
            "passed": trained.passed() && whole.passed(),
            "feasible": smallest_eigenvalue > 0.0,
            "positive_definite": smallest_eigenvalue > 0.0,
            "symmetric": is_none(asymmetry),
            "skew": is_none(skew_defect),
            "friction_passive": trained.driving.is_none(),
            "smallest_eigenvalue": smallest_eigenvalue,
            "asymmetry": asymmetry,
            "skew_defect": skew_defect,
            "trained": range(trained),
            "whole_turn": range(whole),
        });
        found.serialize(serializer)
    }
}

/// `M(q) has the eigenvalue −0.1 kg·m² at q = (0.10, 2.00) rad`.
fn eigenvalue_at(eigenvalue: f64, q: &[f64]) -> String {
    format!("M(q) has the eigenvalue {} kg·m² at q = {} rad", number(eigenvalue), angles(q))
}

fn is_none(defect: f64) -> bool {
    defect < Checks::TOLERANCE
}

fn angles(q: &[f64]) -> String {
    let angles: Vec<String> = q.iter().map(|q| format!("{q:.2}")).collect();
    format!("({})", angles.join(", "))
}

/// (q, dq), evenly drawn from ranges of angles, and from the speeds the model was fitted on; from −π
/// to π and 1 rad/s where none are given.
fn random_states(model: &Model, q_range: &[[f64; 2]], count: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let of_joint = |joint: usize| {
        let q = q_range.get(joint).copied().unwrap_or([-PI, PI]);
        (q, model.training.dq_peak.get(joint).copied().unwrap_or(1.0))
    };
    let ranges: Vec<([f64; 2], f64)> = (0..model.n_joints()).map(of_joint).collect();
    (0..count)
        .map(|_| {
            let state =
                |&([low, high], peak): &([f64; 2], f64)| (between(low, high), between(-peak, peak));
            ranges.iter().map(state).unzip()
        })
        .collect()
}

//! The model: terms and weights, as plain data.

use crate::verdict::{Grade, Verdict};
pub use crate::weighted::Weighted;
use crate::{EnergyTerm, FrictionTerm, JointKinds, ModelError, RigidChain, Sum, Term};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use torquewise_motion::Repairs;

/// The two shapes a model comes in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Form {
    /// Each joint's torque on its own: τᵢ = Σ coefficient · term (product library).
    Torque(Vec<Vec<Weighted<Term>>>),
    /// Energies shared by all joints: M(q) and V(q) (energy library).
    Energy(Vec<Weighted<EnergyTerm>>),
}

impl Default for Form {
    fn default() -> Self {
        Self::Torque(Vec::new())
    }
}

/// What was known after one step of the reconstruction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Name of the pattern whose rows were used.
    pub name: String,
    /// Its rows.
    pub rows: usize,
    /// Number of candidates offered.
    pub candidates: usize,
    /// All that was found up to and with this step.
    pub form: Form,
    /// Friction as it was known then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub friction: Vec<Weighted<FrictionTerm>>,
}

/// What was chosen on held-out data, and from what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// What there was to choose, such as `friction`.
    pub what: String,
    /// Label of the candidate that was taken.
    pub chosen: String,
    /// How, such as `one standard error, 5 blocks in time`.
    pub rule: String,
    /// What it was chosen from, in the order in which it is to be read.
    pub from: Vec<Candidate>,
}

/// A candidate of a choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Candidate {
    /// Its name, as [`Choice::chosen`] has it.
    pub label: String,
    /// Error on held-out rows: mean NRMSE over the joints, a fraction of 1.
    pub error: f64,
    /// Standard error of that.
    pub std_error: f64,
    /// Number of coefficients.
    pub complexity: usize,
}

/// How signals were filtered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingFilter {
    /// Cut-off of the zero-phase low-pass \[Hz\].
    pub cutoff_hz: f64,
    /// Seconds by which the torque lagged the motion.
    pub delay: f64,
}

/// The data a model was fitted on, kept to judge what it is asked later.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Training {
    /// Rows of the log.
    pub rows: usize,
    /// Digests of the positions of its trajectories, ascending; of many the least.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub digests: Vec<u32>,
    /// Which of its joints slide, of a model without a chain.
    #[serde(default, skip_serializing_if = "JointKinds::all_turn")]
    pub kinds: JointKinds,
    /// RMS of the residual torque of each joint \[N·m\], n.
    pub residual_rms: Vec<f64>,
    /// Standard deviation of the torque of each joint \[N·m\], n.
    pub torque_std: Vec<f64>,
    /// Least and greatest position of each joint \[rad\], n.
    pub q_range: Vec<[f64; 2]>,
    /// Largest speed of each joint \[rad/s\], n.
    pub dq_peak: Vec<f64>,
    /// Largest acceleration of each joint \[rad/s²\], n.
    pub ddq_peak: Vec<f64>,
    /// How the signals were filtered, if they were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter: Option<TrainingFilter>,
    /// What was repaired in each log, by its name; logs that are sound are not listed (E12).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub conditioning: BTreeMap<String, Repairs>,
    /// RMS of what is left of the raw torque of each joint \[N·m\] on held-out rows and that noise in
    /// q, q̇ and q̈ does not explain, n, where a chain was fitted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unexplained_rms: Vec<f64>,
    /// RMS of what is left of the torque of each joint \[N·m\] on blocks of time that were held
    /// out, n, where a chain was fitted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_out_rms: Vec<f64>,
    /// The same on regions of configuration that were held out, n (E20).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_out_by_region_rms: Vec<f64>,
    /// How often the geometry of a chain was found, where it was searched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry_found: Option<GeometryFound>,
    /// Whether the model may be used, and why, by the log that it was fitted to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
}

/// How a search of the geometry found it: an arm that a single start led to may be another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryFound {
    /// Starts that led to as good an arm as the best.
    pub times: usize,
    /// Starts that were made.
    pub starts: usize,
    /// Joints, counted from 0, whose axis may lie elsewhere: held-out rows hardly mind another right
    /// angle to the one before, or a joint nearer to the base always moves with one farther out.
    #[serde(default)]
    pub unresolved: Vec<usize>,
}

impl GeometryFound {
    /// As many starts make an arm certain.
    pub const CERTAIN: usize = torquewise_rigid::search::AGREEING;

    /// Whether so many starts led to it that the arm is no other.
    pub fn is_certain(&self) -> bool {
        self.times >= Self::CERTAIN
    }
}

/// A closed-form torque model τ = M(q)q̈ + C(q,q̇)q̇ + G(q) + F(q̇) (1) (17).
///
/// The default is of an arm without joints: the start of a model that is written out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Joint names, base to tip, n.
    pub joints: Vec<String>,
    /// Terms and weights. Where there is a chain, those of its terms that its torque needs but for a
    /// tenth of the residual: equations to read, not to compute with.
    pub form: Form,
    /// The chain of rigid bodies that the torque is computed from, if one was learned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chain: Option<RigidChain>,
    /// Friction of the shafts, n entries each; none for an arm without.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub friction: Vec<Weighted<FrictionTerm>>,
    /// The model after each step, if it was found stepwise.
    pub stages: Vec<Stage>,
    /// What it was fitted on.
    pub training: Training,
    /// What was chosen on held-out data, if anything was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<Choice>,
}

impl Training {
    /// Held-out error over the spread of the torque from which a joint is predicted poorly.
    pub const POOR: f64 = 0.3;

    /// A joint whose position changes by no more \[rad or m\] never moves.
    pub const AT_REST: f64 = 1e-3;

    /// Joints whose position never changes, but for quanta of an encoder.
    ///
    /// - `q_range`: least and greatest position of each joint, n
    pub fn constant_joints(q_range: &[[f64; 2]]) -> Vec<usize> {
        let is_constant = |joint: &usize| q_range[*joint][1] - q_range[*joint][0] <= Self::AT_REST;
        (0..q_range.len()).filter(is_constant).collect()
    }

    /// The verdict of a fit that says that the model should not be used.
    pub fn useless(&self) -> Option<&Verdict> {
        self.verdict.as_ref().filter(|own| own.grade == Grade::Unusable)
    }

    /// RMS of what is to be expected of the torque of each joint \[N·m\] on other rows, n: the residual,
    /// or what was left of rows that were held out, by time or by region, whichever is largest.
    pub fn unseen_rms(&self) -> Vec<f64> {
        let of_joint = |(joint, residual): (usize, &f64)| {
            let held_out = [&self.held_out_rms, &self.held_out_by_region_rms].into_iter();
            held_out.filter_map(|rms| rms.get(joint).copied()).fold(*residual, f64::max)
        };
        self.residual_rms.iter().enumerate().map(of_joint).collect()
    }

    /// Error of each joint on rows that were held out, by time or by region, whichever is larger,
    /// over the standard deviation of its torque, n; `None` where nothing was held out.
    pub fn held_out_errors(&self) -> Option<Vec<f64>> {
        if self.held_out_rms.is_empty() {
            return None;
        }
        let part = |(joint, by_time): (usize, &f64)| {
            let by_region = self.held_out_by_region_rms.get(joint).copied().unwrap_or(0.0);
            let std = self.torque_std[joint];
            if std > 0.0 { by_time.max(by_region) / std } else { 0.0 }
        };
        Some(self.held_out_rms.iter().enumerate().map(part).collect())
    }

    /// The same for a table \[%\], NaN where the torque never changes; empty where nothing was held out.
    pub fn held_out_percent(&self) -> Vec<f64> {
        let errors = self.held_out_errors().unwrap_or_default().into_iter().zip(&self.torque_std);
        errors.map(|(error, std)| if *std > 0.0 { 100.0 * error } else { f64::NAN }).collect()
    }
}

impl Form {
    /// τᵢ as a sum of terms for each of n joints, equal terms joined.
    pub fn equations(&self, n_joints: usize) -> Vec<Sum> {
        let plain = |terms: Vec<Weighted<Term>>| {
            terms.into_iter().map(|w| (w.coefficient, w.term)).collect()
        };
        self.weighted(n_joints).into_iter().map(plain).collect()
    }

    /// The same with the standard error of each weight: where an energy term is the only source of
    /// a torque term, that of its coefficient scaled; where several meet, they are independent.
    pub(crate) fn weighted(&self, n_joints: usize) -> Vec<Vec<Weighted<Term>>> {
        let terms = match self {
            Self::Torque(joints) => return joints.clone(),
            Self::Energy(terms) => terms,
        };
        let of_joint = |joint| {
            let mut sums: BTreeMap<Term, (f64, f64)> = BTreeMap::new();
            for w in terms {
                for (weight, term) in w.term.torque(joint) {
                    let sum = sums.entry(term).or_insert((0.0, 0.0));
                    sum.0 += weight * w.coefficient;
                    sum.1 += (weight * w.std_error).powi(2);
                }
            }
            let weighted = |(term, (coefficient, variance)): (Term, (f64, f64))| Weighted {
                std_error: variance.sqrt(),
                ..Weighted::new(term, coefficient)
            };
            sums.into_iter().filter(|(_, sum)| sum.0 != 0.0).map(weighted).collect()
        };
        (0..n_joints).map(of_joint).collect()
    }

    /// Number of coefficients.
    pub fn n_coefficients(&self) -> usize {
        match self {
            Self::Torque(joints) => joints.iter().map(Vec::len).sum(),
            Self::Energy(terms) => terms.len(),
        }
    }
}

impl Model {
    /// Number of joints n.
    pub fn n_joints(&self) -> usize {
        self.joints.len()
    }

    /// Speeds below which joints are taken to rest \[rad/s\], n: dry friction then holds them with whatever
    /// is asked of it.
    pub fn rest_speeds(&self) -> Vec<f64> {
        /// Part of the peak speed that the model was fitted to.
        const SLOW: f64 = 0.02;
        let peak = |joint| self.training.dq_peak.get(joint).copied().unwrap_or(1.0);
        (0..self.n_joints()).map(|joint| (SLOW * peak(joint)).max(f64::MIN_POSITIVE)).collect()
    }

    /// Which of its joints turn and which slide.
    pub fn kinds(&self) -> JointKinds {
        self.chain.as_ref().map_or(&self.training.kinds, |chain| &chain.kinds).clone()
    }

    /// Number of coefficients, those of friction included.
    pub fn n_coefficients(&self) -> usize {
        self.form.n_coefficients() + self.friction.len()
    }

    /// Travels \[rad\] of the elements by which its friction remembers the path, each once,
    /// ascending; none where it depends on the velocity alone.
    pub fn travels(&self) -> Vec<f64> {
        let elements = self.friction.iter().filter_map(|weighted| weighted.term.element());
        let mut travels: Vec<f64> = elements.map(|(_, travel)| travel).collect();
        travels.sort_by(f64::total_cmp);
        travels.dedup();
        travels
    }

    /// Number of coefficients that act on each joint, those of friction included, n.
    pub fn active(&self) -> Vec<usize> {
        let mut active: Vec<usize> = match &self.form {
            Form::Torque(joints) => joints.iter().map(Vec::len).collect(),
            Form::Energy(terms) => (0..self.n_joints())
                .map(|joint| terms.iter().filter(|w| !w.term.torque(joint).is_empty()).count())
                .collect(),
        };
        for (joint, count) in active.iter_mut().enumerate() {
            *count += self.friction.iter().filter(|w| w.term.acts_on(joint)).count();
        }
        active
    }

    /// τᵢ of each joint as a sum of terms, without friction.
    pub fn equations(&self) -> Vec<Sum> {
        self.form.equations(self.n_joints())
    }

    /// The model as it was after a step, counted from 1 (Fig. 10 of the paper).
    ///
    /// # Errors
    /// [`ModelError::Step`] if there is no such step.
    pub fn after_step(&self, step: usize) -> Result<Self, ModelError> {
        let known = self.stages.len();
        let stage = step.checked_sub(1).and_then(|place| self.stages.get(place));
        let stage = stage.ok_or(ModelError::Step { found: step, known })?;
        let (form, friction) = (stage.form.clone(), stage.friction.clone());
        Ok(Self { form, chain: None, friction, stages: Vec::new(), ..self.clone() })
    }

    /// The same model whose friction reverses within another half width \[rad/s\]; 0 for the
    /// exact sign.
    ///
    /// A learner smooths reversals for the noise of measured velocities. A desired velocity has
    /// none, and a controller tracks better with a reversal as sharp as its drives can follow.
    pub fn with_reversal(&self, width: f64) -> Self {
        let mut model = self.clone();
        let stages = model.stages.iter_mut().flat_map(|stage| &mut stage.friction);
        for weighted in model.friction.iter_mut().chain(stages) {
            weighted.term.law = weighted.term.law.with_width(width);
        }
        model
    }

    /// Whether a log may be of the arm this is a model of.
    ///
    /// # Errors
    /// [`ModelError::JointCount`] or [`ModelError::JointNames`].
    pub fn check_joints(&self, log: &[String]) -> Result<(), ModelError> {
        if self.n_joints() != log.len() {
            return Err(ModelError::JointCount { model: self.n_joints(), log: log.len() });
        }
        if self.joints != log {
            return Err(ModelError::JointNames { model: self.joints.clone(), log: log.to_vec() });
        }
        Ok(())
    }
}

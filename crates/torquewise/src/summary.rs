//! What a fit found in numbers: the object that programs read.

use crate::error::Result;
use crate::fit::FitResult;
use crate::physics::MassMatrix;
use serde::Serialize;
use std::collections::BTreeMap;
use torquewise_model::model::{Choice, GeometryFound};
use torquewise_motion::Repairs;
use torquewise_stepwise::fit::Dropped;
use torquewise_stepwise::{NoiseFloor, StepReport};

/// A fit in numbers; percentages are of the standard deviation of the torque of a joint.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "fields of a JSON object, explained in docs/library.md")]
pub struct FitSummary<'a> {
    pub verdict: String,
    pub because: Vec<String>,
    pub joints: &'a [String],
    pub rows: usize,
    pub seconds: f64,
    pub residual_rms: &'a [f64],
    pub torque_std: &'a [f64],
    pub residual_percent: Vec<f64>,
    pub held_out_percent: Vec<f64>,
    pub held_out_by_region_percent: Vec<f64>,
    pub cutoff_hz: Option<f64>,
    pub delay_s: Option<f64>,
    pub geometry_found: Option<GeometryFound>,
    pub conditioning: AllRepairs<'a>,
    pub candidates: usize,
    pub candidates_by_step: Vec<usize>,
    pub active: Vec<usize>,
    pub active_total: usize,
    pub steps: Vec<TimedStep<'a>>,
    pub choices: &'a [Choice],
    pub noise: &'a NoiseFloor,
    pub dropped: &'a [Dropped],
    pub mass_matrix: &'a MassMatrix,
}

/// A step of the reconstruction, and the time it took \[s\].
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "fields of a JSON object, explained in docs/library.md")]
pub struct TimedStep<'a> {
    #[serde(flatten)]
    pub step: &'a StepReport,
    pub seconds: f64,
}

/// What was repaired in all logs, and in each.
#[derive(Clone, Debug, Serialize)]
pub struct AllRepairs<'a> {
    /// All logs together.
    pub total: Repairs,
    /// By the name of the log; logs that are sound are not listed.
    pub logs: &'a BTreeMap<String, Repairs>,
}

impl<'a> AllRepairs<'a> {
    /// Adds up what was repaired.
    pub fn of(logs: &'a BTreeMap<String, Repairs>) -> Self {
        Self { total: logs.values().sum(), logs }
    }
}

/// What was repaired in all logs together, in words; none if they are sound.
pub fn repairs_note(logs: &BTreeMap<String, Repairs>) -> Option<String> {
    (!logs.is_empty()).then(|| AllRepairs::of(logs).total.to_string())
}

impl FitResult {
    /// What was found in numbers, to be serialised.
    ///
    /// # Errors
    /// `Error::Model` if M(q) cannot be computed.
    pub fn summary(&self) -> Result<FitSummary<'_>> {
        let (verdict, model) = (self.verdict(), &self.model);
        let training = &model.training;
        let percent = |rms: &[f64]| {
            rms.iter().zip(&training.torque_std).map(|(rms, std)| 100.0 * rms / std).collect()
        };
        let steps = self.steps.iter().zip(&self.step_seconds);
        Ok(FitSummary {
            because: verdict.because,
            verdict: verdict.grade.to_string(),
            joints: &model.joints,
            rows: self.survey.rows,
            seconds: self.seconds,
            residual_rms: &training.residual_rms,
            torque_std: &training.torque_std,
            residual_percent: percent(&training.residual_rms),
            held_out_percent: percent(&training.held_out_rms),
            held_out_by_region_percent: percent(&training.held_out_by_region_rms),
            cutoff_hz: training.filter.map(|filter| filter.cutoff_hz),
            delay_s: training.filter.map(|filter| filter.delay),
            geometry_found: training.geometry_found.clone(),
            conditioning: AllRepairs::of(&training.conditioning),
            candidates: self.candidates,
            candidates_by_step: self.steps.iter().map(|step| step.candidates).collect(),
            active: model.active(),
            active_total: model.n_coefficients(),
            steps: steps.map(|(step, &seconds)| TimedStep { step, seconds }).collect(),
            choices: &model.choices,
            noise: &self.noise,
            dropped: &self.dropped,
            mass_matrix: self.mass_matrix()?,
        })
    }
}

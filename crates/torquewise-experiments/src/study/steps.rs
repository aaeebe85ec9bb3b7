//! From models after each step to error and torque of the same motion (Fig. 10, simulated).

use crate::agenda::Trials;
use crate::error::ExperimentError;
use crate::method::Method;
use crate::scenario::outside;
use crate::settings::Settings;
use crate::study::cases::{CasePlan, predict};
use crate::trial::judge_steps;
use serde::Serialize;

/// What each step of a method adds.
#[derive(Clone, Debug, Serialize)]
pub struct StepResults {
    pub method: Method,
    /// Names of the steps: the patterns of their rows.
    pub names: Vec<String>,
    /// Error outside the training log after each step \[%\], per joint.
    pub nrmse_percent: Vec<Vec<f64>>,
    /// The same after the last refit.
    pub refitted_nrmse_percent: Vec<f64>,
    /// Torque after each step \[N·m\], steps × n × m, at the instants of the case's prediction.
    pub torque: Vec<Vec<Vec<f64>>>,
}

/// The steps of both libraries, on the first log of a case.
pub(crate) fn study_steps(
    case: &CasePlan,
    settings: &Settings,
    trials: &Trials,
) -> Result<Vec<StepResults>, ExperimentError> {
    let test = outside(settings.arm, settings.seed)?;
    let mut results = Vec::new();
    for method in [Method::Energy, Method::Product] {
        let Some(&first) = case.trials(method).first() else { continue };
        let trial = trials.get(first)?;
        let model = &trial.model;
        let torque = (1..=model.stages.len())
            .map(|step| predict(&model.after_step(step)?, &test))
            .collect::<Result<_, _>>()?;
        results.push(StepResults {
            method,
            names: model.stages.iter().map(|stage| stage.name.clone()).collect(),
            nrmse_percent: judge_steps(model, &test)?,
            refitted_nrmse_percent: trial.nrmse_percent.clone(),
            torque,
        });
    }
    Ok(results)
}

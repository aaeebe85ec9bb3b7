//! Stepwise reconstruction beside one-shot SINDy, on the same logs.

use crate::error::Result;
use crate::fit::{FitResult, fit_plan};
use crate::observe::{NOBODY, Observer, Watched};
use crate::options::FitOptions;
use serde::Serialize;
use torquewise_identify::Method;
use torquewise_identify::plan::LibraryOptions;
use torquewise_identify::score::{Scores, score};
use torquewise_motion::Recording;
use torquewise_stepwise::candidates::check_library;

/// Both methods.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Standstill, uniform and variable velocity in turn.
    pub stepwise: Contender,
    /// The product library on all rows at once.
    pub sindy: Contender,
}

/// What a method came to.
#[derive(Debug, Serialize)]
pub struct Contender {
    /// The fit itself.
    #[serde(skip)]
    pub fit: FitResult,
    /// Terms offered.
    pub candidates: usize,
    /// The same step by step.
    pub candidates_by_step: Vec<usize>,
    /// Time it took \[s\].
    pub seconds: f64,
    /// Terms that act on each joint, n.
    pub active: Vec<usize>,
    /// Terms in all.
    pub active_total: usize,
    /// Error on the test log of each joint, of the standard deviation of its torque \[%\], n.
    pub nrmse_percent: Vec<f64>,
    /// The same \[N·m\], n.
    pub rmse: Vec<f64>,
}

/// Fits both methods to a training recording and scores them on a test recording.
///
/// # Errors
/// `Error::UnusedOption`, `Error::CompareChain`, and those of fitting.
pub fn compare(
    train: &dyn Recording,
    test: &dyn Recording,
    options: &FitOptions,
    observer: Observer<'_>,
) -> Result<Comparison> {
    let [stepwise, sindy] = options.plans_to_compare()?;
    // Neither is fitted where the other could not be.
    for plan in [&stepwise, &sindy] {
        if let Method::Library(LibraryOptions { library, kinds, regression, .. }) = &plan.method {
            check_library(&kinds.all(train.joints().len()), *library, *regression)?;
        }
    }
    let contend = |plan| -> Result<Contender> {
        let fit = fit_plan(train, None, plan, observer)?;
        let scores = score(&fit.model, &Watched::new(test, NOBODY, "predicting", None))?;
        Ok(Contender::new(fit, &scores))
    };
    Ok(Comparison { stepwise: contend(&stepwise)?, sindy: contend(&sindy)? })
}

impl Contender {
    fn new(fit: FitResult, scores: &Scores) -> Self {
        Self {
            candidates: fit.candidates,
            candidates_by_step: fit.steps.iter().map(|step| step.candidates).collect(),
            seconds: fit.seconds,
            active: fit.model.active(),
            active_total: fit.model.n_coefficients(),
            nrmse_percent: scores.joints.iter().map(|joint| joint.nrmse_percent).collect(),
            rmse: scores.joints.iter().map(|joint| joint.rmse).collect(),
            fit,
        }
    }
}

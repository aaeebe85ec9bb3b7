//! Stepwise reconstruction beside one-shot SINDy, on the same logs.

use crate::fit::fit_plan;
use crate::{FitOptions, FitResult, NOBODY, Observer, Result, Watched};
use serde::{Serialize, Serializer};
use serde_json::json;
use torquewise_identify::{LibraryOptions, Method, Scores, score};
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
#[derive(Debug)]
pub struct Contender {
    /// The fit itself.
    pub fit: FitResult,
    /// Its errors on the test log.
    pub scores: Scores,
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
        let fit = fit_plan(&Watched::new(train, observer, "reading", None), plan)?;
        let scores = score(&fit.model, &Watched::new(test, NOBODY, "predicting", None))?;
        Ok(Contender { fit, scores })
    };
    Ok(Comparison { stepwise: contend(&stepwise)?, sindy: contend(&sindy)? })
}

impl Contender {
    /// Error on the test log of each joint, of the standard deviation of its torque \[%\], n.
    pub fn nrmse_percent(&self) -> Vec<f64> {
        self.scores.joints.iter().map(|joint| joint.nrmse_percent).collect()
    }
}

impl Serialize for Contender {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { fit, scores } = self;
        let found = json!({
            "candidates": fit.candidates,
            "candidates_by_step": fit.steps.iter().map(|step| step.candidates).collect::<Vec<_>>(),
            "seconds": fit.seconds,
            "active": fit.model.active(),
            "active_total": fit.model.n_coefficients(),
            "nrmse_percent": self.nrmse_percent(),
            "rmse": scores.joints.iter().map(|joint| joint.rmse).collect::<Vec<_>>(),
        });
        found.serialize(serializer)
    }
}

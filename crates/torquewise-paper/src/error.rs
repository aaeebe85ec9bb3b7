//! What can keep an experiment from being done.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_identify::IdentifyError;
use torquewise_model::ModelError;
use torquewise_motion::MotionError;
use torquewise_report::ReportError;
use torquewise_sim::SimError;

/// Why there are no results, figures or report.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum PaperError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Simulation(#[from] SimError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error("experiment {experiment}")]
    #[diagnostic(forward(source))]
    Identify { experiment: String, source: IdentifyError },
    #[error("no thread can be started for the experiments")]
    #[diagnostic(help("free some memory or allow more threads"))]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("the results cannot be written as JSON")]
    Json(#[from] serde_json::Error),
}

pub(crate) type Result<T = (), E = PaperError> = std::result::Result<T, E>;

/// Names the experiment in which a reconstruction failed.
pub(crate) fn within(experiment: impl Into<String>) -> impl FnOnce(IdentifyError) -> PaperError {
    |source| PaperError::Identify { experiment: experiment.into(), source }
}

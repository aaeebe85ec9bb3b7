//! What can keep a figure or a report from being made.
#![expect(missing_docs, reason = "each message explains its fields")]

use torquewise_model::ModelError;

/// What fails by [`ReportError`].
pub type Result<T, E = ReportError> = std::result::Result<T, E>;

/// Why there is no figure or report.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum ReportError {
    #[error("residuals of {found} joints are not of a model of {expected}")]
    #[diagnostic(help("give what `diagnose` says of the model that was reconstructed"))]
    Joints { found: usize, expected: usize },
    #[error("costs of {found} models, expected {expected}: one for each step, and the whole")]
    #[diagnostic(help("count all of them, or none"))]
    Costs { found: usize, expected: usize },
    #[error("a report of {rows} rows and {joints} joints shows nothing")]
    #[diagnostic(help("give two rows of one joint"))]
    Empty { rows: usize, joints: usize },
    #[error("the figure cannot be drawn, {reason}")]
    #[diagnostic(help("check that its values are of ordinary size"))]
    Drawing { reason: String },
    #[error("the page cannot be written")]
    #[diagnostic(help("report this as an error of this program"))]
    Page(#[from] minijinja::Error),
    #[error("the data of a chart cannot be written")]
    #[diagnostic(help("report this as an error of this program"))]
    Data(#[from] serde_json::Error),
    #[error("the model after step {step} cannot be evaluated")]
    #[diagnostic(help("fit it anew"))]
    Step { step: usize, source: ModelError },
}
